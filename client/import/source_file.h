// The files that an import may read: the one that was asked for, and those that it names below its
// own folder.
//
//   auto bytes = ReadFile("scenes/table.gltf");
//   auto buffer = ReadUri("scenes", "table%20top.bin", "buffers[0].uri");
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace penumbra {

// 4 GiB: past that a scene should be split, and GLB's own lengths end.
inline constexpr uint64_t kMaxSourceFileBytes = uint64_t{1} << 32;

// Errors  kNotFound; kPermissionDenied; kInvalidArgument: not a regular file;
//         kResourceExhausted: longer than kMaxSourceFileBytes
absl::StatusOr<std::vector<std::byte>> ReadFile(const std::filesystem::path& path);

// What a glTF `uri` holds: a data URI's bytes, or those of a file in `folder` or below it, whose
// name may be percent-encoded. Schemes, absolute names, "..", and links that leave `folder` are
// refused.
//
// Errors  as ReadFile, and kPermissionDenied, reason URI_ESCAPES; kInvalidArgument, reason BAD_URI;
//         each names `field_path`
absl::StatusOr<std::vector<std::byte>> ReadUri(const std::filesystem::path& folder,
                                               std::string_view uri, std::string_view field_path);

// A relative file name (not percent-encoded) resolved as by ReadUri.
absl::StatusOr<std::filesystem::path> ResolveBelow(const std::filesystem::path& folder,
                                                   std::string_view name,
                                                   std::string_view field_path);

// `bytes` as text; the view lives as long as the bytes.
inline std::string_view AsText(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// A file's text shortened and made printable, for messages.
std::string Quoted(std::string_view text, size_t longest = 60);

// kInvalidArgument at `field_path`: "found …, need …".
absl::Status Malformed(std::string_view reason, std::string_view field_path,
                       std::string_view found_and_need);

}  // namespace penumbra
