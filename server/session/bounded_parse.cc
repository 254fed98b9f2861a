#include "server/session/bounded_parse.h"

#include <algorithm>
#include <string>

#include "google/protobuf/descriptor.h"
#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/wire_format_lite.h"
#include "grpcpp/support/slice.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::internal::WireFormatLite;

// As deep as protobuf itself goes.
constexpr int kMaxDepth = 100;

absl::Status Exhausted(const char* reason, const std::string& text) {
  return FieldError(absl::StatusCode::kResourceExhausted, reason, "request", text);
}

absl::Status Malformed() {
  return FieldError(
      absl::StatusCode::kInvalidArgument, "MALFORMED", "request",
      "found bytes that are no such message, need a protobuf message with UTF-8 text");
}

// Beside what it holds, an object takes its allocation's own bytes and its place in a list.
constexpr int64_t kAllocationBytes = 32;
constexpr int64_t kStringBytes = sizeof(std::string) + kAllocationBytes;
constexpr int64_t kUnknownFieldBytes = 64;  // a string of its own, and an entry in a growing list

int64_t EmptyBytes(const Descriptor& type) {
  const google::protobuf::Message* prototype =
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(&type);
  return static_cast<int64_t>(prototype->SpaceUsedLong()) + kAllocationBytes;
}

// Whether protobuf reads what comes under `field` with this wire type, or keeps it as unknown.
bool IsRead(const FieldDescriptor* field, WireFormatLite::WireType wire_type) {
  if (!field) return false;
  const auto type = static_cast<WireFormatLite::FieldType>(field->type());
  if (wire_type == WireFormatLite::WireTypeForFieldType(type)) return true;
  return field->is_packable() && wire_type == WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
}

// Adds up what a message on the wire will take, beside its own bytes, until it is more than `most`.
// Groups, which no message of ours has, count as malformed.
class ParsedSize {
 public:
  explicit ParsedSize(int64_t most) : most_(most) {}

  bool Add(google::protobuf::io::CodedInputStream& in, const Descriptor& type, int depth) {
    while (!is_over()) {
      const uint32_t tag = in.ReadTag();
      if (tag == 0) return in.ConsumedEntireMessage();
      const FieldDescriptor* field = type.FindFieldByNumber(WireFormatLite::GetTagFieldNumber(tag));
      const auto wire_type = WireFormatLite::GetTagWireType(tag);
      if (wire_type == WireFormatLite::WIRETYPE_START_GROUP) return false;
      has_unknown_ = has_unknown_ || !IsRead(field, wire_type);
      const bool is_long = wire_type == WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
      if (is_long && field && field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        bytes_ += EmptyBytes(*field->message_type());
        if (!AddNested(in, *field->message_type(), depth)) return false;
        continue;
      }
      if (is_long || !field) bytes_ += field ? kStringBytes : kUnknownFieldBytes;
      if (!WireFormatLite::SkipField(&in, tag)) return false;
    }
    return true;
  }

  bool is_over() const { return bytes_ > most_; }
  // Fields that the message's type does not have, in it or in what it holds.
  bool has_unknown() const { return has_unknown_; }

 private:
  bool AddNested(google::protobuf::io::CodedInputStream& in, const Descriptor& type, int depth) {
    int length = 0;
    if (depth == kMaxDepth || !in.ReadVarintSizeAsInt(&length)) return false;
    const auto limit = in.PushLimit(length);
    if (!Add(in, type, depth + 1)) return false;
    if (is_over()) return true;
    if (in.BytesUntilLimit() != 0) return false;
    in.PopLimit(limit);
    return true;
  }

  const int64_t most_;
  int64_t bytes_ = 0;
  bool has_unknown_ = false;
};

}  // namespace

absl::Status ParseBounded(std::span<const uint8_t> bytes, const ServerLimits& limits,
                          google::protobuf::Message& message) {
  if (bytes.size() > limits.max_message_bytes) {
    return Exhausted("QUOTA_MESSAGE_BYTES", "found " + std::to_string(bytes.size()) +
                                                " bytes, need at most " +
                                                std::to_string(limits.max_message_bytes));
  }
  const int64_t most = std::max(int64_t{limits.always_allowed_parsed_bytes},
                                static_cast<int64_t>(bytes.size()) * limits.parsed_bytes_per_byte);
  google::protobuf::io::CodedInputStream in(bytes.data(), static_cast<int>(bytes.size()));
  ParsedSize parsed(most);
  if (!parsed.Add(in, *message.GetDescriptor(), 0)) return Malformed();
  if (parsed.is_over()) {
    return Exhausted("QUOTA_ELEMENTS", "found " + std::to_string(bytes.size()) +
                                           " bytes of so many sub-messages and strings that they "
                                           "take more than " +
                                           std::to_string(most) + " in memory, need fewer");
  }
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return Malformed();
  if (parsed.has_unknown()) message.DiscardUnknownFields();
  return absl::OkStatus();
}

absl::Status ParseBounded(const grpc::ByteBuffer& buffer, const ServerLimits& limits,
                          google::protobuf::Message& message) {
  grpc::Slice slice;
  if (!buffer.TrySingleSlice(&slice).ok() && !buffer.DumpToSingleSlice(&slice).ok()) {
    return Malformed();
  }
  return ParseBounded(std::span<const uint8_t>(slice.begin(), slice.size()), limits, message);
}

}  // namespace penumbra
