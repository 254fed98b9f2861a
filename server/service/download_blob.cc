#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/status_convert.h"
#include "render/math/hand_over.h"
#include "render/scene/blob.h"
#include "render/scene/field_error.h"
#include "server/service/call_record.h"
#include "server/service/idle_timer.h"
#include "server/service/penumbra_service.h"
#include "server/service/refused_stream.h"
#include "server/session/bounded_parse.h"
#include "server/session/wire_message.h"

namespace penumbra {
namespace {

// Room for the message's other fields.
constexpr size_t kEnvelopeBytes = 64;

class DownloadReactor final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  DownloadReactor(const ServiceParts& parts, const Caller& caller,
                  grpc::CallbackServerContext* context)
      : parts_(parts),
        chunk_bytes_(parts.sessions.limits.max_message_bytes - kEnvelopeBytes),
        timer_(IdleTimer::Start(context, parts.sessions.limits.transfer_idle_timeout)),
        right_(parts.guard.Follow(caller, nullptr, context)) {}

  void Start(const grpc::ByteBuffer& request, const Identity& identity) {
    v1::DownloadBlobRequest message;
    if (auto status = ParseBounded(request, parts_.sessions.limits, message); !status.ok()) {
      return End(status);
    }
    const auto hash = HashFromProto(message.hash(), "hash");
    if (!hash.ok()) return End(hash.status());
    auto content = parts_.sessions.blobs.FindBlob(*hash);
    if (!content || !parts_.sessions.blob_access.MaySee(identity, *hash)) {
      return End(FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "hash",
                            "found " + hash->hex() + ", need a stored blob"));
    }
    blob_.emplace(*std::move(content));
    SendNext();
  }

  void OnWriteDone(bool ok) override {
    callbacks_.Take();
    timer_->Touch();
    if (!ok) return End(absl::CancelledError("the client is gone"));
    SendNext();
  }

  void OnDone() override {
    callbacks_.Take();
    timer_->Stop();
    right_->Finish();
    delete this;
  }

 private:
  void End(const absl::Status& status) {
    record_.End(status);
    callbacks_.Give();
    Finish(ToGrpcStatus(status));
  }

  void SendNext() {
    if (sent_ == blob_->size()) return End(absl::OkStatus());
    const size_t size = std::min(chunk_bytes_, blob_->size() - sent_);
    v1::DownloadBlobResponse response;
    if (sent_ == 0) response.set_size_bytes(blob_->size());
    std::string& data = *response.mutable_data();
    data.resize(size);
    blob_->CopyTo(reinterpret_cast<std::byte*>(data.data()), sent_, size);
    sent_ += size;
    message_ = ToBytes(response);
    callbacks_.Give();
    StartWrite(&message_);
  }

  HandOver callbacks_;  // gRPC calls one after another, on any of its threads
  const ServiceParts& parts_;
  CallRecord record_{parts_.sessions.counters, parts_.logger, "DownloadBlob"};
  const size_t chunk_bytes_;
  const std::shared_ptr<IdleTimer> timer_;
  const std::shared_ptr<LiveCall> right_;
  std::optional<EncodedBlob> blob_;
  size_t sent_ = 0;
  grpc::ByteBuffer message_;
};

}  // namespace

grpc::ServerWriteReactor<grpc::ByteBuffer>* PenumbraService::DownloadBlob(Context* context,
                                                                          const Bytes* request) {
  const auto caller = parts_.guard.Admit(*context, "DownloadBlob");
  if (!caller.ok()) return new RefusedStream<grpc::ServerWriteReactor<Bytes>>(caller.status());
  auto* reactor = new DownloadReactor(parts_, *caller, context);
  reactor->Start(*request, caller->identity());
  return reactor;
}

}  // namespace penumbra
