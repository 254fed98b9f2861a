#include "tests/fuzz/kit/script.h"

#include <algorithm>

namespace penumbra::fuzzing {
namespace {

constexpr size_t kHeadBytes = 5;

}  // namespace

std::string EncodeScript(const Script& script) {
  std::string bytes;
  for (const Step& step : script) {
    bytes.push_back(static_cast<char>(step.kind));
    for (int shift = 0; shift < 32; shift += 8) {
      bytes.push_back(static_cast<char>(step.payload.size() >> shift));
    }
    bytes += step.payload;
  }
  return bytes;
}

Script DecodeScript(std::string_view bytes) {
  Script script;
  while (bytes.size() >= kHeadBytes) {
    const auto kind = static_cast<uint8_t>(bytes[0]);
    size_t length = 0;
    for (size_t i = 4; i > 0; --i) length = length << 8 | static_cast<uint8_t>(bytes[i]);
    bytes.remove_prefix(kHeadBytes);
    length = std::min(length, bytes.size());
    script.push_back({.kind = kind, .payload = std::string(bytes.substr(0, length))});
    bytes.remove_prefix(length);
  }
  return script;
}

}  // namespace penumbra::fuzzing
