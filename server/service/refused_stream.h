// A stream that the guard has not let in.
//
//   if (!caller.ok()) return new RefusedStream<grpc::ServerReadReactor<Bytes>>(caller.status());
#pragma once

#include "absl/status/status.h"
#include "proto/convert/status_convert.h"

namespace penumbra {

template <typename Reactor>
class RefusedStream final : public Reactor {
 public:
  explicit RefusedStream(const absl::Status& status) { this->Finish(ToGrpcStatus(status)); }
  void OnDone() override { delete this; }
};

}  // namespace penumbra
