#include "tests/support/disk_image.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

namespace penumbra::testing {
namespace {

constexpr uint64_t kSectorBytes = 512;

std::string ContentOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Put(std::string& content, uint64_t at, std::string_view bytes) {
  if (content.size() < at + bytes.size()) content.resize(at + bytes.size());
  std::copy(bytes.begin(), bytes.end(), content.begin() + static_cast<ptrdiff_t>(at));
}

}  // namespace

void DiskImage::OnOpen(const std::string& path) {
  // One that was written beside its place, and then renamed.
  if (const auto beside = files_.find(path + ".new");
      beside != files_.end() && !std::filesystem::exists(beside->first)) {
    files_[path] = std::move(beside->second);
    files_.erase(beside);
  }
  const auto [file, is_new] = files_.try_emplace(path);
  file->second.is_deleted = false;
  if (!is_new) return;
  file->second.durable = ContentOf(path);
  file->second.is_known = !file->second.durable.empty();
}

void DiskImage::OnWrite(const std::string& path, uint64_t at, std::string bytes) {
  files_[path].changes.push_back({.at = at, .bytes = std::move(bytes)});
}

void DiskImage::OnTruncate(const std::string& path, uint64_t size) {
  files_[path].changes.push_back({.at = size, .bytes = {}});
}

void DiskImage::OnSync(const std::string& path) {
  File& file = files_[path];
  for (const Change& change : std::exchange(file.changes, {})) {
    if (change.bytes.empty()) {
      file.durable.resize(change.at);
    } else {
      Put(file.durable, change.at, change.bytes);
    }
  }
  file.is_known = true;
}

void DiskImage::OnDelete(const std::string& path, bool is_synced) {
  const auto file = files_.find(path);
  if (file == files_.end()) return;
  file->second.is_deleted = true;
  if (is_synced) files_.erase(file);
}

void DiskImage::LosePower(Luck luck, std::mt19937& random) {
  const auto happens = [&] {
    return luck == Luck::kSome ? (random() & 1) == 1 : luck == Luck::kEverything;
  };
  for (auto& [path, file] : files_) {
    for (const Change& change : std::exchange(file.changes, {})) {
      if (change.bytes.empty()) {
        if (happens()) file.durable.resize(change.at);
        continue;
      }
      const std::string_view bytes(change.bytes);
      for (uint64_t done = 0; done < bytes.size();) {
        const uint64_t at = change.at + done;
        const uint64_t count = std::min(bytes.size() - done, kSectorBytes - at % kSectorBytes);
        if (happens()) Put(file.durable, at, bytes.substr(done, count));
        done += count;
      }
    }
    std::filesystem::remove(path);
    const bool is_there = file.is_deleted ? !happens() : file.is_known || happens();
    if (is_there) std::ofstream(path, std::ios::binary) << file.durable;
  }
  files_.clear();
}

}  // namespace penumbra::testing
