#include "server/storage/blob_files.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include "render/scene/field_error.h"
#include "server/storage/durable_file.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

constexpr size_t kChunkBytes = 1u << 20;

}  // namespace

std::string BlobFiles::FolderOf(const ContentHash& hash) const {
  return folder_ + "/" + hash.hex().substr(0, 2);
}

std::string BlobFiles::PathOf(const ContentHash& hash) const {
  return FolderOf(hash) + "/" + hash.hex();
}

absl::Status BlobFiles::Write(const ContentHash& hash, const BlobContent& content) {
  std::error_code error;
  if (fs::exists(PathOf(hash), error)) {
    // A crash may have come between its name and the folders' being synced.
    if (auto status = SyncFolder(FolderOf(hash)); !status.ok()) return status;
    return SyncFolder(folder_);
  }
  if (::mkdir(FolderOf(hash).c_str(), 0700) == 0) {
    if (auto status = SyncFolder(folder_); !status.ok()) return status;
  } else if (errno != EEXIST) {
    return FileError(FolderOf(hash), errno);
  }
  const EncodedBlob blob(content);
  return WriteDurably(PathOf(hash), [&](const Append& append) -> absl::Status {
    std::string chunk;
    for (size_t at = 0; at < blob.size(); at += chunk.size()) {
      chunk.resize(std::min(kChunkBytes, blob.size() - at));
      blob.CopyTo(reinterpret_cast<std::byte*>(chunk.data()), at, chunk.size());
      if (auto status = append(chunk); !status.ok()) return status;
    }
    return absl::OkStatus();
  });
}

absl::StatusOr<std::string> BlobFiles::Read(const ContentHash& hash) const {
  auto content = ReadFileIfThere(PathOf(hash));
  if (content.ok() && content->empty()) {
    return FieldError(absl::StatusCode::kNotFound, "MISSING_BLOB", "blob",
                      "found no file of " + hash.hex() + ", need it");
  }
  return content;
}

absl::Status BlobFiles::Remove(const ContentHash& hash) { return RemoveDurably(PathOf(hash)); }

absl::Status BlobFiles::PutAside(const ContentHash& hash) {
  std::error_code error;
  fs::rename(PathOf(hash), PathOf(hash) + ".damaged", error);
  return error ? FileError(PathOf(hash), error.value()) : SyncFolder(FolderOf(hash));
}

absl::StatusOr<std::vector<ContentHash>> BlobFiles::List() {
  std::vector<ContentHash> hashes;
  std::error_code error;
  fs::recursive_directory_iterator file(folder_, error);
  for (; !error && file != fs::recursive_directory_iterator(); file.increment(error)) {
    if (const auto hash = ContentHash::FromHex(file->path().filename().string())) {
      hashes.push_back(*hash);
    } else if (file->path().extension() == ".new") {
      std::error_code ignored;
      fs::remove(file->path(), ignored);
    }
  }
  if (error) return FileError(folder_, error.value());
  std::sort(hashes.begin(), hashes.end());
  return hashes;
}

}  // namespace penumbra
