#include "client/import/source_file.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <system_error>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

absl::string_view View(std::string_view text) { return {text.data(), text.size()}; }

std::optional<int> HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return std::nullopt;
}

// "%20" → " "; a percent sign that starts no escape stays what it is.
std::string PercentDecode(std::string_view text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size()) {
      const std::optional<int> high = HexDigit(text[i + 1]);
      const std::optional<int> low = HexDigit(text[i + 2]);
      if (high && low) {
        out.push_back(static_cast<char>(*high * 16 + *low));
        i += 2;
        continue;
      }
    }
    out.push_back(text[i]);
  }
  return out;
}

// Whether `text` starts with a scheme such as "https:"; one letter is a drive.
bool HasScheme(std::string_view text) {
  const size_t colon = text.find(':');
  if (colon == std::string_view::npos || colon == 0) return false;
  return std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(colon), [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '+' || c == '-' || c == '.';
  });
}

absl::StatusOr<std::vector<std::byte>> DecodeDataUri(std::string_view uri,
                                                     std::string_view field_path) {
  const size_t comma = uri.find(',');
  if (comma == std::string_view::npos) {
    return Malformed("BAD_URI", field_path, "found a data URI with no comma, need one");
  }
  const std::string_view payload = uri.substr(comma + 1);
  std::string decoded;
  if (!uri.substr(0, comma).ends_with(";base64")) {
    decoded = PercentDecode(payload);
  } else if (!absl::Base64Unescape(View(payload), &decoded)) {
    return Malformed("BAD_URI", field_path, "found a broken base64 data URI, need valid base64");
  }
  const auto bytes = std::as_bytes(std::span(decoded));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

absl::Status Escapes(std::string_view name, std::string_view field_path) {
  return FieldError(absl::StatusCode::kPermissionDenied, "URI_ESCAPES", field_path,
                    absl::StrCat("found ", Quoted(name),
                                 ", need the relative name of a file in the scene's folder or "
                                 "below it"));
}

}  // namespace

absl::Status Malformed(std::string_view reason, std::string_view field_path,
                       std::string_view found_and_need) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field_path, found_and_need);
}

std::string Quoted(std::string_view text, size_t longest) {
  const std::string escaped = absl::CHexEscape(View(text.substr(0, longest)));
  return absl::StrCat("\"", escaped, text.size() > longest ? "…" : "", "\"");
}

absl::StatusOr<std::vector<std::byte>> ReadFile(const fs::path& path) {
  const std::string name = path.filename().string();
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    return FieldError(absl::StatusCode::kNotFound, "NO_FILE", name,
                      absl::StrCat("found no file at ", Quoted(path.string()), ", need one"));
  }
  if (status.type() != fs::file_type::regular) {
    return Malformed("NOT_A_FILE", name, "found something else, need a regular file");
  }
  const uint64_t size = fs::file_size(path, error);
  if (error || size > kMaxSourceFileBytes) {
    return FieldError(absl::StatusCode::kResourceExhausted, "TOO_LARGE", name,
                      absl::StrCat("found ", size, " bytes, need <= ", kMaxSourceFileBytes));
  }
  std::ifstream file(path, std::ios::binary);
  std::vector<std::byte> bytes(size);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!file.is_open() || file.bad() || static_cast<uint64_t>(file.gcount()) != size) {
    return FieldError(absl::StatusCode::kPermissionDenied, "UNREADABLE", name,
                      "found a file that cannot be read, need a readable one");
  }
  return bytes;
}

absl::StatusOr<fs::path> ResolveBelow(const fs::path& folder, std::string_view name,
                                      std::string_view field_path) {
  if (name.empty() || name.find('\0') != std::string_view::npos) {
    return Malformed("BAD_URI", field_path,
                     absl::StrCat("found ", Quoted(name), ", need a file name"));
  }
  if (HasScheme(name) || name.find('\\') != std::string_view::npos)
    return Escapes(name, field_path);
  const fs::path relative = fs::path(name).lexically_normal();
  if (relative.is_absolute() || *relative.begin() == "..") return Escapes(name, field_path);
  // Links count as where they lead to.
  std::error_code error;
  const fs::path root = fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, error);
  const fs::path resolved = fs::weakly_canonical(root / relative, error);
  const auto [end_of_root, rest] =
      std::mismatch(root.begin(), root.end(), resolved.begin(), resolved.end());
  if (error || end_of_root != root.end()) return Escapes(name, field_path);
  return resolved;
}

absl::StatusOr<std::vector<std::byte>> ReadUri(const fs::path& folder, std::string_view uri,
                                               std::string_view field_path) {
  if (uri.starts_with("data:")) return DecodeDataUri(uri, field_path);
  // A name with a literal percent sign may be meant as it stands.
  absl::StatusOr<fs::path> path = ResolveBelow(folder, PercentDecode(uri), field_path);
  if (!path.ok()) return path.status();
  absl::StatusOr<std::vector<std::byte>> bytes = ReadFile(*path);
  if (!bytes.ok()) return WithFieldPrefix(bytes.status(), absl::StrCat(View(field_path), ": "));
  return bytes;
}

}  // namespace penumbra
