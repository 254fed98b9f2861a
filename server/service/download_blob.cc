#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/status_convert.h"
#include "render/math/hand_over.h"
#include "render/scene/field_error.h"
#include "server/service/penumbra_service.h"
#include "server/session/bounded_parse.h"
#include "server/session/wire_message.h"

namespace penumbra {
namespace {

// Room for the message's other fields.
constexpr size_t kEnvelopeBytes = 64;

class DownloadReactor final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  explicit DownloadReactor(const ServiceParts& parts)
      : parts_(parts), chunk_bytes_(parts.sessions.limits.max_message_bytes - kEnvelopeBytes) {}

  void Start(const grpc::ByteBuffer& request) {
    v1::DownloadBlobRequest message;
    if (auto status = ParseBounded(request, parts_.sessions.limits, message); !status.ok()) {
      return Finish(ToGrpcStatus(status));
    }
    const auto hash = HashFromProto(message.hash(), "hash");
    if (!hash.ok()) return Finish(ToGrpcStatus(hash.status()));
    auto mesh = parts_.sessions.blobs.FindMesh(*hash);
    auto mask = parts_.sessions.blobs.FindMask(*hash);
    if (!mesh && !mask) {
      return Finish(ToGrpcStatus(FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "hash",
                                            "found " + hash->hex() + ", need a stored blob")));
    }
    parts_.blob_workers.Post([this, mesh = std::move(mesh), mask = std::move(mask)] {
      bytes_ = mesh ? EncodeBlob(mesh->geometry()) : EncodeBlob(*mask);
      SendNext();
    });
  }

  void OnWriteDone(bool ok) override {
    callbacks_.Take();
    if (!ok) return Finish(grpc::Status::CANCELLED);
    SendNext();
  }

  void OnDone() override {
    callbacks_.Take();
    delete this;
  }

 private:
  void SendNext() {
    if (sent_ == bytes_.size()) {
      callbacks_.Give();
      return Finish(grpc::Status::OK);
    }
    const size_t size = std::min(chunk_bytes_, bytes_.size() - sent_);
    v1::DownloadBlobResponse response;
    if (sent_ == 0) response.set_size_bytes(bytes_.size());
    response.set_data(bytes_.data() + sent_, size);
    sent_ += size;
    message_ = ToBytes(response);
    callbacks_.Give();
    StartWrite(&message_);
  }

  HandOver callbacks_;  // gRPC calls one after another, on any of its threads
  const ServiceParts& parts_;
  const size_t chunk_bytes_;
  std::vector<std::byte> bytes_;
  size_t sent_ = 0;
  grpc::ByteBuffer message_;
};

}  // namespace

grpc::ServerWriteReactor<grpc::ByteBuffer>* PenumbraService::DownloadBlob(Context*,
                                                                          const Bytes* request) {
  auto* reactor = new DownloadReactor(parts_);
  reactor->Start(*request);
  return reactor;
}

}  // namespace penumbra
