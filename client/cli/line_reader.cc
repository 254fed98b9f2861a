#include "client/cli/line_reader.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "client/cli/option_error.h"

namespace penumbra {
namespace {

// A stop is seen after this.
constexpr int kLookMs = 100;

}  // namespace

absl::StatusOr<std::unique_ptr<LineReader>> LineReader::Open(const std::filesystem::path& path) {
  const int file = path == "-" ? STDIN_FILENO : open(path.c_str(), O_RDONLY | O_CLOEXEC);
  char nothing;
  if (file < 0 || read(file, &nothing, 0) != 0) {
    if (file > STDIN_FILENO) close(file);
    return OptionError("--script", "CANNOT_READ", {path.native()}, ", need a file that is there");
  }
  return std::unique_ptr<LineReader>(new LineReader(file));
}

LineReader::~LineReader() {
  if (file_ != STDIN_FILENO) close(file_);
}

bool LineReader::is_terminal() const { return isatty(file_) != 0; }

std::optional<std::string> LineReader::TakeLine() {
  const size_t end = read_.find('\n');
  if (end != std::string::npos) {
    std::string line = read_.substr(0, end);
    read_.erase(0, end + 1);
    return line;
  }
  const bool is_due = is_at_end_ ? !read_.empty() : read_.size() >= kMaxLineBytes;
  if (!is_due) return std::nullopt;
  return std::exchange(read_, {});
}

// False: nothing more can come.
bool LineReader::Read(const std::stop_token& stop) {
  pollfd waiting{.fd = file_, .events = POLLIN, .revents = 0};
  int ready = 0;
  while (ready == 0) {
    if (stop.stop_requested()) return false;
    ready = poll(&waiting, 1, kLookMs);
    if (ready < 0 && errno == EINTR) ready = 0;
  }
  char bytes[4096];
  const ssize_t count = ready < 0 ? -1 : read(file_, bytes, sizeof bytes);
  if (count < 0 && errno == EINTR) return true;
  is_at_end_ = count <= 0;
  if (count > 0) read_.append(bytes, static_cast<size_t>(count));
  return true;
}

std::optional<std::string> LineReader::Next(const std::stop_token& stop) {
  for (;;) {
    if (stop.stop_requested()) return std::nullopt;
    if (auto line = TakeLine()) return line;
    if (is_at_end_ || !Read(stop)) return std::nullopt;
  }
}

}  // namespace penumbra
