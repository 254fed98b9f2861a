// Lines of a file or of standard input, which may take their time.
//
//   auto reader = LineReader::Open("-");
//   while (auto line = reader->Next(stop)) Do(*line);
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"

namespace penumbra {

class LineReader {
 public:
  // Longer lines are cut into several.
  static constexpr size_t kMaxLineBytes = size_t{1} << 16;

  // "-": standard input.
  //
  // Errors  kInvalidArgument CANNOT_READ, "--script"
  static absl::StatusOr<std::unique_ptr<LineReader>> Open(const std::filesystem::path& path);
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  // Without its end. None: there is none any more, or a stop was asked for.
  std::optional<std::string> Next(const std::stop_token& stop);
  // Whether somebody types.
  bool is_terminal() const;

 private:
  explicit LineReader(int file) : file_(file) {}
  bool Read(const std::stop_token& stop);
  std::optional<std::string> TakeLine();

  const int file_;
  std::string read_;  // and not given out
  bool is_at_end_ = false;
};

}  // namespace penumbra
