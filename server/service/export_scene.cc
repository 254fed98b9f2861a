#include <memory>
#include <string>
#include <utility>

#include "proto/convert/status_convert.h"
#include "render/math/hand_over.h"
#include "server/service/archive_clock.h"
#include "server/service/call_record.h"
#include "server/service/idle_timer.h"
#include "server/service/penumbra_service.h"
#include "server/service/refused_stream.h"
#include "server/service/unary_call.h"

namespace penumbra {
namespace {

// Each message is made on a thread for archives, which waits for the disk and not for the client.
class ExportReactor final : public grpc::ServerWriteReactor<grpc::ByteBuffer> {
 public:
  ExportReactor(const ServiceParts& parts, const Caller& caller,
                grpc::CallbackServerContext* context, v1::ExportSceneRequest request)
      : parts_(parts),
        context_(*context),
        principal_(caller.identity().name),
        request_(std::move(request)),
        timer_(IdleTimer::Start(context, parts.sessions.limits.transfer_idle_timeout)),
        right_(parts.guard.Follow(caller, nullptr, context)) {}

  void Start() {
    if (auto status = clock_.Start(parts_.archives); !status.ok()) return End(status);
    callbacks_.Give();
    parts_.transfers.archives().Post(principal_, [this] {
      callbacks_.Take();
      Begin();
    });
  }

  void OnWriteDone(bool ok) override {
    callbacks_.Take();
    timer_->Touch();
    if (!ok) return End(absl::CancelledError("the client is gone"));
    if (is_last_) return End(absl::OkStatus());
    GoOn();
  }

  void OnDone() override {
    callbacks_.Take();
    timer_->Stop();
    right_->Finish();
    delete this;
  }

 private:
  void Begin() {
    auto exported = parts_.archives.Export(request_.scene_id(), !request_.without_history());
    if (!exported.ok()) return End(exported.status());
    exported_ = *std::move(exported);
    SendNext();
  }

  // When the caller has its next turn.
  void GoOn() {
    if (auto status = clock_.Check(parts_.sessions.limits); !status.ok()) return End(status);
    callbacks_.Give();
    parts_.transfers.archives().Post(principal_, [this] {
      callbacks_.Take();
      SendNext();
    });
  }

  void SendNext() {
    v1::ExportSceneResponse response;
    const auto more = exported_->Next(response);
    if (!more.ok()) return End(more.status());
    if (*more && response.records().empty()) {
      // A long history that is looked through, while the client can do nothing but wait.
      if (context_.IsCancelled()) return End(absl::CancelledError("the client is gone"));
      timer_->Touch();
      return GoOn();
    }
    is_last_ = !*more;
    message_ = ToBytes(response);
    callbacks_.Give();
    StartWrite(&message_);
  }

  // Lets the history go, and its turn, before the client can hear of the end.
  void End(const absl::Status& status) {
    exported_.reset();
    clock_.Finish();
    record_.End(status);
    callbacks_.Give();
    Finish(ToGrpcStatus(status));
  }

  HandOver callbacks_;  // one after another, on any of gRPC's threads or those for archives
  const ServiceParts& parts_;
  CallRecord record_{parts_.sessions.counters, parts_.logger, "ExportScene"};
  const grpc::CallbackServerContext& context_;
  const std::string principal_;
  const v1::ExportSceneRequest request_;
  ArchiveClock clock_;
  const std::shared_ptr<IdleTimer> timer_;
  const std::shared_ptr<LiveCall> right_;
  std::unique_ptr<SceneExport> exported_;
  bool is_last_ = false;
  grpc::ByteBuffer message_;
};

}  // namespace

grpc::ServerWriteReactor<grpc::ByteBuffer>* PenumbraService::ExportScene(Context* context,
                                                                         const Bytes* request) {
  v1::ExportSceneRequest message;
  const auto caller = AdmitRequest(*context, parts_, *request, message);
  if (!caller.ok()) {
    CallRecord(parts_.sessions.counters, parts_.logger, "ExportScene").End(caller.status());
    return new RefusedStream<grpc::ServerWriteReactor<Bytes>>(caller.status());
  }
  auto* reactor = new ExportReactor(parts_, *caller, context, std::move(message));
  reactor->Start();
  return reactor;
}

}  // namespace penumbra
