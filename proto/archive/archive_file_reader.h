// Reads the records of a file as archive_file.h says, and holds each against its seal.
//
//   auto reader = ArchiveFileReader::Open("studio.penumbra");
//   while (true) {
//     auto record = (*reader)->Next();
//     if (!record.ok()) return record.status();   // "studio.penumbra: byte 4711, record 12: …"
//     if (!*record) break;
//   }
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "penumbra/v1/archive.pb.h"
#include "render/scene/content_hash.h"

namespace penumbra {

class ArchiveFileReader {
 public:
  // Errors  kNotFound: no file that can be read; kInvalidArgument ARCHIVE_FORMAT: no archive;
  //         kFailedPrecondition VERSION: one of a newer format
  static absl::StatusOr<std::unique_ptr<ArchiveFileReader>> Open(const std::filesystem::path& path);

  // None after the end. Errors  kDataLoss DAMAGED, with the byte and the record where the file is
  // cut or another one than was written
  absl::StatusOr<std::optional<v1::ArchiveRecord>> Next();

  // What has been read so far, and what there is.
  uint64_t read_bytes() const { return read_bytes_; }
  uint64_t size_bytes() const { return size_bytes_; }

  // Puts the place of the record that was read last before an error about it.
  absl::Status AtRecord(const absl::Status& status) const;

 private:
  explicit ArchiveFileReader(const std::filesystem::path& path);
  std::string Place() const;
  absl::Status Damaged(const std::string& found) const;

  const std::filesystem::path path_;
  std::ifstream file_;
  ContentHash seal_;
  uint64_t size_bytes_ = 0;
  uint64_t read_bytes_ = 0;
  uint64_t record_at_ = 0;  // where the record that is being read begins
  uint64_t record_count_ = 0;
  bool has_ended_ = false;
};

}  // namespace penumbra
