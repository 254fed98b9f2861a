// What a fuzz target is fed: steps one after another, each of a kind and with a payload.
//
//   u8 kind, u32 little-endian length, payload …
//
// Bytes that are no whole step are read as far as they go, so that every input is a script.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace google::protobuf {
class Message;
}

namespace penumbra::fuzzing {

struct Step {
  uint8_t kind = 0;  // an index into the target's kinds, modulo their number
  std::string payload;
};

using Script = std::vector<Step>;

std::string EncodeScript(const Script& script);
Script DecodeScript(std::string_view bytes);

// What the payloads of a kind of step are.
struct StepKind {
  std::string_view name;
  const google::protobuf::Message* message = nullptr;  // one like them; null: bytes or text
};

}  // namespace penumbra::fuzzing
