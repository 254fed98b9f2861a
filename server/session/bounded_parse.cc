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

// Counts the elements of a message on the wire, up to one past `most`. Groups, which no message of
// ours has, count as malformed.
class ElementCount {
 public:
  explicit ElementCount(int64_t most) : most_(most) {}

  bool Count(google::protobuf::io::CodedInputStream& in, const Descriptor& type, int depth) {
    while (count_ <= most_) {
      const uint32_t tag = in.ReadTag();
      if (tag == 0) return in.ConsumedEntireMessage();
      const FieldDescriptor* field = type.FindFieldByNumber(WireFormatLite::GetTagFieldNumber(tag));
      const auto wire_type = WireFormatLite::GetTagWireType(tag);
      if (wire_type == WireFormatLite::WIRETYPE_START_GROUP) return false;
      const bool is_long = wire_type == WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
      if (is_long || !field) ++count_;
      if (is_long && field && field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        if (!CountNested(in, *field->message_type(), depth)) return false;
      } else if (!WireFormatLite::SkipField(&in, tag)) {
        return false;
      }
    }
    return true;
  }

  int64_t count() const { return count_; }

 private:
  bool CountNested(google::protobuf::io::CodedInputStream& in, const Descriptor& type, int depth) {
    int length = 0;
    if (depth == kMaxDepth || !in.ReadVarintSizeAsInt(&length)) return false;
    const auto limit = in.PushLimit(length);
    if (!Count(in, type, depth + 1)) return false;
    if (count_ > most_) return true;
    if (in.BytesUntilLimit() != 0) return false;
    in.PopLimit(limit);
    return true;
  }

  const int64_t most_;
  int64_t count_ = 0;
};

}  // namespace

absl::Status ParseBounded(std::span<const uint8_t> bytes, const ServerLimits& limits,
                          google::protobuf::Message& message) {
  if (bytes.size() > limits.max_message_bytes) {
    return Exhausted("QUOTA_MESSAGE_BYTES", "found " + std::to_string(bytes.size()) +
                                                " bytes, need at most " +
                                                std::to_string(limits.max_message_bytes));
  }
  const int64_t most =
      std::max<int64_t>(limits.always_allowed_elements,
                        static_cast<int64_t>(bytes.size() / limits.min_bytes_per_element));
  google::protobuf::io::CodedInputStream in(bytes.data(), static_cast<int>(bytes.size()));
  ElementCount elements(most);
  if (!elements.Count(in, *message.GetDescriptor(), 0)) return Malformed();
  if (elements.count() > most) {
    return Exhausted("QUOTA_ELEMENTS", "found more than " + std::to_string(most) +
                                           " sub-messages and strings in " +
                                           std::to_string(bytes.size()) + " bytes, need fewer");
  }
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return Malformed();
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
