#include "server/session/wire_message.h"

#include "grpcpp/support/slice.h"

namespace penumbra {

grpc::ByteBuffer ToBytes(const google::protobuf::Message& message) {
  const grpc::Slice slice(message.SerializeAsString());
  return grpc::ByteBuffer(&slice, 1);
}

}  // namespace penumbra
