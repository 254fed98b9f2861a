// A session whose client sends bytes of its own making, and the bytes that it makes them of.
#pragma once

#include <memory>
#include <string>

#include "grpcpp/channel.h"
#include "grpcpp/support/byte_buffer.h"
#include "gtest/gtest.h"
#include "proto/convert/status_convert.h"
#include "tests/integration/service/wire_client.h"

namespace penumbra::testing {

class RawSession {
 public:
  explicit RawSession(WireClient& client)
      : stream_(
            grpc::internal::ClientReaderWriterFactory<grpc::ByteBuffer, grpc::ByteBuffer>::Create(
                client.channel().get(),
                grpc::internal::RpcMethod("/penumbra.v1.PenumbraService/Session",
                                          grpc::internal::RpcMethod::BIDI_STREAMING),
                &context_)) {}
  ~RawSession() {
    context_.TryCancel();
    if (!has_ended_) stream_->Finish();
  }

  void Send(const std::string& bytes) {
    const grpc::Slice slice(bytes);
    stream_->Write(grpc::ByteBuffer(&slice, 1));
  }
  v1::SessionResponse Ask(const std::string& bytes) {
    Send(bytes);
    grpc::ByteBuffer buffer;
    v1::SessionResponse response;
    grpc::Slice back;
    if (!stream_->Read(&buffer) || !buffer.DumpToSingleSlice(&back).ok() ||
        !response.ParseFromArray(back.begin(), static_cast<int>(back.size()))) {
      ADD_FAILURE() << "the session ended";
    }
    return response;
  }
  absl::Status Error(const std::string& bytes) {
    return FromProto(Ask(bytes).session_error().error());
  }
  // Reads the rest, and says how the call ended.
  absl::Status End() {
    grpc::ByteBuffer rest;
    while (stream_->Read(&rest)) {
    }
    has_ended_ = true;
    return FromGrpcStatus(stream_->Finish());
  }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>> stream_;
  bool has_ended_ = false;
};

// A field of bytes, text or a message, as it stands on the wire.
inline std::string Field(int number, const std::string& content) {
  std::string bytes(1, static_cast<char>(number << 3 | 2));
  for (size_t size = content.size();; size >>= 7) {
    bytes += static_cast<char>(size < 0x80 ? size : (size & 0x7f) | 0x80);
    if (size < 0x80) return bytes + content;
  }
}

inline std::string HelloBytes(const std::string& scene_id = "studio") {
  v1::SessionRequest request;
  request.mutable_hello()->set_scene_id(scene_id);
  request.mutable_hello()->add_protocol_versions(1);
  return request.SerializeAsString();
}

}  // namespace penumbra::testing
