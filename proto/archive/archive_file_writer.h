// Writes records into a file as archive_file.h says.
//
//   auto writer = ArchiveFileWriter::Create("studio.penumbra");
//   (*writer)->Write(record);   // each
//   (*writer)->Finish();        // now there is such a file
//
// Until then the records are in a file of this writer's own in the same folder. Where the path is a
// link, what it leads to is written.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>

#include "absl/status/statusor.h"
#include "penumbra/v1/archive.pb.h"
#include "render/scene/content_hash.h"

namespace penumbra {

class ArchiveFileWriter {
 public:
  // Errors, of all  kUnavailable: the file cannot be written
  // Errors          kFailedPrecondition: a folder, a device or a pipe has the path
  static absl::StatusOr<std::unique_ptr<ArchiveFileWriter>> Create(
      const std::filesystem::path& path);
  // Removes what has been written, unless it is finished.
  ~ArchiveFileWriter();

  absl::Status Write(const v1::ArchiveRecord& record);
  // Gives the file its name, in place of the file that had it. When this returns, all of it is on
  // the disk.
  absl::Status Finish();

  uint64_t size_bytes() const { return size_bytes_; }

 private:
  struct Closes {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  explicit ArchiveFileWriter(const std::filesystem::path& path);
  absl::Status CannotWrite() const;  // by errno
  bool OpenBeside();
  bool Append(std::string_view bytes);

  const std::filesystem::path path_;    // as it was given
  const std::filesystem::path target_;  // without links
  std::filesystem::path beside_;
  std::unique_ptr<std::FILE, Closes> file_;  // null: finished
  ContentHash seal_;
  uint64_t size_bytes_ = 0;
};

}  // namespace penumbra
