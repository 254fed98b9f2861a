#include "server/security/small_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr std::streamsize kMaxBytes = 1 << 20;

}  // namespace

absl::StatusOr<std::string> ReadSmallFile(const std::string& path, const std::string& option) {
  const auto failed = [&](const char* why) {
    return FieldError(absl::StatusCode::kInvalidArgument, "CANNOT_READ", option,
                      absl::StrCat("found ", path, ": ", why, ", need a file to read"));
  };
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return failed(std::strerror(errno));
  std::string text(kMaxBytes + 1, '\0');
  file.read(text.data(), kMaxBytes + 1);
  if (file.bad()) return failed(std::strerror(errno));
  if (file.gcount() > kMaxBytes) return failed("more than 1 MiB");
  text.resize(static_cast<size_t>(file.gcount()));
  return text;
}

}  // namespace penumbra
