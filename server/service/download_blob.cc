#include <algorithm>
#include <memory>
#include <string>
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
      return End(ToGrpcStatus(status));
    }
    const auto hash = HashFromProto(message.hash(), "hash");
    if (!hash.ok()) return End(ToGrpcStatus(hash.status()));
    parts_.blob_workers.Post([this, hash = *hash] {
      bytes_ = parts_.sessions.blobs.Encoded(hash);
      if (bytes_) return SendNext();
      End(ToGrpcStatus(FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "hash",
                                  "found " + hash.hex() + ", need a stored blob")));
    });
  }

  void OnWriteDone(bool ok) override {
    callbacks_.Take();
    if (!ok) return End(grpc::Status::CANCELLED);
    SendNext();
  }

  void OnDone() override {
    callbacks_.Take();
    delete this;
  }

 private:
  void End(const grpc::Status& status) {
    callbacks_.Give();
    Finish(status);
  }

  void SendNext() {
    if (sent_ == bytes_->size()) return End(grpc::Status::OK);
    const size_t size = std::min(chunk_bytes_, bytes_->size() - sent_);
    v1::DownloadBlobResponse response;
    if (sent_ == 0) response.set_size_bytes(bytes_->size());
    response.set_data(bytes_->data() + sent_, size);
    sent_ += size;
    message_ = ToBytes(response);
    callbacks_.Give();
    StartWrite(&message_);
  }

  HandOver callbacks_;  // gRPC calls one after another, on any of its threads
  const ServiceParts& parts_;
  const size_t chunk_bytes_;
  std::shared_ptr<const std::vector<std::byte>> bytes_;  // however slowly the client reads
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
