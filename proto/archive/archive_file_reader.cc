#include "proto/archive/archive_file_reader.h"

#include <system_error>

#include "absl/strings/str_cat.h"
#include "proto/archive/archive_file.h"
#include "render/scene/field_error.h"

namespace penumbra {

ArchiveFileReader::ArchiveFileReader(const std::filesystem::path& path)
    : path_(path), file_(path, std::ios::binary), seal_(FirstSeal()) {}

absl::StatusOr<std::unique_ptr<ArchiveFileReader>> ArchiveFileReader::Open(
    const std::filesystem::path& path) {
  std::unique_ptr<ArchiveFileReader> reader(new ArchiveFileReader(path));
  std::error_code error;
  reader->size_bytes_ = std::filesystem::file_size(path, error);
  if (!reader->file_.good() || error) {
    return absl::NotFoundError(
        absl::StrCat(path.string(), ": found no file to read, need an archive"));
  }
  std::string line(kArchiveFirstLine.size(), '\0');
  reader->file_.read(line.data(), static_cast<std::streamsize>(line.size()));
  if (line == kArchiveFirstLine) {
    reader->read_bytes_ = line.size();
    return reader;
  }
  if (line.starts_with(kArchiveName)) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "VERSION", path.string(),
                      "found an archive of another format, need format 1");
  }
  return FieldError(absl::StatusCode::kInvalidArgument, "ARCHIVE_FORMAT", path.string(),
                    "found a file that is no archive, need one of `penumbra scenes export`");
}

std::string ArchiveFileReader::Place() const {
  return absl::StrCat(path_.string(), ": byte ", record_at_, ", record ", record_count_);
}

absl::Status ArchiveFileReader::Damaged(const std::string& found) const {
  return FieldError(absl::StatusCode::kDataLoss, "DAMAGED", Place(),
                    absl::StrCat("found ", found, ", need the archive as it was written"));
}

absl::Status ArchiveFileReader::AtRecord(const absl::Status& status) const {
  const bool has_field = !ErrorFieldPath(status).empty();
  return WithFieldPrefix(status, has_field ? Place() + ": " : Place());
}

absl::StatusOr<std::optional<v1::ArchiveRecord>> ArchiveFileReader::Next() {
  record_at_ = read_bytes_;
  if (has_ended_) {
    if (file_.peek() == std::ifstream::traits_type::eof()) return std::nullopt;
    return Damaged("something after the end");
  }
  std::string framed(kSizeBytes, '\0');
  if (!file_.read(framed.data(), kSizeBytes)) return Damaged("the file's end");
  const size_t size = SizeIn(framed);
  if (size == 0 || size > kMaxRecordBytes) return Damaged("a size that no record has");
  if (size + kSealBytes > size_bytes_ - record_at_ - kSizeBytes) return Damaged("the file's end");
  framed.resize(kSizeBytes + size);
  ContentHash seal;
  file_.read(framed.data() + kSizeBytes, static_cast<std::streamsize>(size));
  file_.read(reinterpret_cast<char*>(seal.bytes.data()), kSealBytes);
  if (!file_.good()) return Damaged("the file's end");
  seal_ = NextSeal(seal_, framed);
  v1::ArchiveRecord record;
  if (seal != seal_ || !record.ParseFromArray(framed.data() + kSizeBytes, static_cast<int>(size))) {
    return Damaged("other bytes than their seal says");
  }
  read_bytes_ += framed.size() + kSealBytes;
  ++record_count_;
  has_ended_ = record.has_end();
  return record;
}

}  // namespace penumbra
