// Bytes of a client into a message, without letting few bytes become much memory.
//
//   v1::SessionRequest request;
//   if (auto status = ParseBounded(buffer, limits, request); !status.ok()) …
#pragma once

#include <cstdint>
#include <span>

#include "absl/status/status.h"
#include "google/protobuf/message.h"
#include "grpcpp/support/byte_buffer.h"
#include "server/limits.h"

namespace penumbra {

// Estimates what the sub-messages, strings, byte fields and unknown fields in `bytes` take when
// they are parsed, before anything is allocated for them. Unknown fields are dropped: nobody checks
// what is in them, and a message that is kept or told to others would carry them along.
//
// Errors  kResourceExhausted QUOTA_MESSAGE_BYTES: longer than limits.max_message_bytes;
//         kResourceExhausted QUOTA_ELEMENTS: more than honest messages of this length take;
//         kInvalidArgument MALFORMED: not a message of this type, or text that is not UTF-8
absl::Status ParseBounded(std::span<const uint8_t> bytes, const ServerLimits& limits,
                          google::protobuf::Message& message);
absl::Status ParseBounded(const grpc::ByteBuffer& buffer, const ServerLimits& limits,
                          google::protobuf::Message& message);

}  // namespace penumbra
