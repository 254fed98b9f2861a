// Messages as bytes for gRPC.
#pragma once

#include "google/protobuf/message.h"
#include "grpcpp/support/byte_buffer.h"

namespace penumbra {

grpc::ByteBuffer ToBytes(const google::protobuf::Message& message);

}  // namespace penumbra
