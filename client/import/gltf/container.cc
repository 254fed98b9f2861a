#include "client/import/gltf/container.h"

#include <cstdint>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/import/source_file.h"

namespace penumbra::gltf {
namespace {

constexpr uint32_t kMagic = 0x46546c67;  // "glTF"
constexpr uint32_t kJson = 0x4e4f534a;
constexpr uint32_t kBin = 0x004e4942;
constexpr size_t kHeaderBytes = 12;
constexpr size_t kChunkHeaderBytes = 8;

uint32_t U32At(std::span<const std::byte> bytes, size_t offset) {
  uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | std::to_integer<uint32_t>(bytes[offset + i]);
  return value;
}

absl::Status CheckHeader(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeaderBytes) {
    return Malformed("GLB", "glb.header",
                     absl::StrCat("found ", bytes.size(), " bytes, need ", kHeaderBytes));
  }
  if (const uint32_t version = U32At(bytes, 4); version != 2) {
    return Malformed("GLB", "glb.version", absl::StrCat("found ", version, ", need 2"));
  }
  const uint32_t length = U32At(bytes, 8);
  if (length < kHeaderBytes || length > bytes.size()) {
    return Malformed("GLB", "glb.length",
                     absl::StrCat("found ", length, ", need ", kHeaderBytes, " to ", bytes.size(),
                                  ", the file's size"));
  }
  return absl::OkStatus();
}

// JSON comes first, BIN second or not at all; chunks of other types are to be skipped.
absl::Status CheckOrder(size_t chunk, uint32_t type, const std::string& path) {
  if ((chunk == 0) == (type == kJson) && (chunk <= 1 || type != kBin)) return absl::OkStatus();
  return Malformed("GLB", path + ".type",
                   absl::StrCat("found 0x", absl::Hex(type, absl::kZeroPad8), ", need ",
                                chunk == 0 ? "JSON" : "another, JSON being first and BIN second"));
}

}  // namespace

bool IsGlb(std::span<const std::byte> bytes) {
  return bytes.size() >= 4 && U32At(bytes, 0) == kMagic;
}

absl::StatusOr<Container> SplitContainer(std::span<const std::byte> bytes) {
  if (!IsGlb(bytes)) {
    std::string_view text = AsText(bytes);
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    return Container{.json = text};
  }
  if (absl::Status status = CheckHeader(bytes); !status.ok()) return status;
  Container container;
  std::span<const std::byte> rest = bytes.first(U32At(bytes, 8)).subspan(kHeaderBytes);
  for (size_t chunk = 0; !rest.empty(); ++chunk) {
    const std::string path = absl::StrCat("glb.chunks[", chunk, "]");
    if (rest.size() < kChunkHeaderBytes) {
      return Malformed(
          "GLB", path,
          absl::StrCat("found ", rest.size(), " bytes, need at least ", kChunkHeaderBytes));
    }
    const uint32_t length = U32At(rest, 0), type = U32At(rest, 4);
    if (length > rest.size() - kChunkHeaderBytes) {
      return Malformed("GLB", path + ".length",
                       absl::StrCat("found ", length, ", need <= ", rest.size() - kChunkHeaderBytes,
                                    ", what the file still has"));
    }
    const auto content = rest.subspan(kChunkHeaderBytes, length);
    if (absl::Status status = CheckOrder(chunk, type, path); !status.ok()) return status;
    if (type == kJson) container.json = AsText(content);
    if (type == kBin) container.bin = content;
    rest = rest.subspan(kChunkHeaderBytes + length);
  }
  if (container.json.data() == nullptr) {
    return Malformed("GLB", "glb.chunks", "found none, need a JSON chunk");
  }
  return container;
}

}  // namespace penumbra::gltf
