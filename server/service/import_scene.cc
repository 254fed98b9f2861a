#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "proto/convert/scene_convert.h"
#include "proto/convert/status_convert.h"
#include "render/math/hand_over.h"
#include "render/scene/field_error.h"
#include "server/security/blob_access.h"
#include "server/service/archive_clock.h"
#include "server/service/call_record.h"
#include "server/service/idle_timer.h"
#include "server/service/penumbra_service.h"
#include "server/service/refused_stream.h"
#include "server/session/bounded_parse.h"
#include "server/session/wire_message.h"

namespace penumbra {
namespace {

// Each message is taken in on a thread for archives: scenes are made and hashed there, and it may
// wait for the disk.
class ImportReactor final : public grpc::ServerReadReactor<grpc::ByteBuffer> {
 public:
  ImportReactor(const ServiceParts& parts, const Caller& caller,
                grpc::CallbackServerContext* context, grpc::ByteBuffer* response)
      : parts_(parts),
        context_(*context),
        caller_(caller),
        blobs_(parts.sessions.blobs, parts.sessions.blob_access, caller_.identity()),
        response_bytes_(response),
        timer_(IdleTimer::Start(context, parts.sessions.limits.transfer_idle_timeout)),
        right_(parts.guard.Follow(caller, nullptr, context)) {}

  void Start() {
    if (auto status = clock_.Start(parts_.archives); !status.ok()) return End(status);
    ReadNext();
  }

  void OnReadDone(bool ok) override {
    callbacks_.Take();
    timer_->Touch();
    callbacks_.Give();
    parts_.transfers.archives().Post(caller_.identity().name, [this, ok] {
      callbacks_.Take();
      if (!ok) return FinishImport();
      if (auto status = TakeMessage(); !status.ok()) return End(status);
      ReadNext();
    });
  }

  void OnDone() override {
    callbacks_.Take();
    timer_->Stop();
    right_->Finish();
    delete this;
  }

 private:
  void ReadNext() {
    callbacks_.Give();
    StartRead(&bytes_);
  }

  absl::Status TakeMessage() {
    if (auto status = clock_.Check(parts_.sessions.limits); !status.ok()) return status;
    v1::ImportSceneRequest request;
    if (auto status = ParseBounded(bytes_, parts_.sessions.limits, request); !status.ok()) {
      return status;
    }
    bytes_.Clear();
    if (!import_) {
      const std::string& scene_id = request.scene_id();
      if (auto status = caller_.Authorize("ImportScene", scene_id); !status.ok()) return status;
      const std::string& name = caller_.identity().name;
      auto begun = parts_.archives.Import(
          scene_id, {.name = name, .max_scenes = parts_.sessions.quotas.Of(name).scenes}, blobs_);
      if (!begun.ok()) return begun.status();
      import_ = *std::move(begun);
    } else if (!request.scene_id().empty()) {
      return FieldError(absl::StatusCode::kInvalidArgument, "UNEXPECTED_FIELD", "scene_id",
                        "found one in a later message, need it in the first");
    }
    for (const v1::ArchiveRecord& record : request.records()) {
      if (auto status = import_->Take(record); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  // Whether the client waits for the scene and may have it.
  absl::Status CheckWanted() const {
    if (context_.IsCancelled()) return absl::CancelledError("the call was cancelled");
    if (auto status = clock_.Check(parts_.sessions.limits); !status.ok()) return status;
    return right_->StillAllowed();
  }

  // The client has sent all, or is gone, which reads the same. Nothing comes of an archive without
  // its end, nor of a call that is over.
  void FinishImport() {
    if (auto status = CheckWanted(); !status.ok()) return End(status);
    if (!import_) {
      return End(FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "scene_id",
                            "found no message, need one"));
    }
    const auto info = import_->Finish([this] { return CheckWanted(); });
    if (!info.ok()) return End(info.status());
    v1::ImportSceneResponse response;
    *response.mutable_scene() = ToProto(*info);
    *response_bytes_ = ToBytes(response);
    End(absl::OkStatus());
  }

  // Removes what there is of a scene, and gives its turn back, before the client can hear of it.
  void End(const absl::Status& status) {
    import_.reset();
    clock_.Finish();
    record_.End(status);
    callbacks_.Give();
    Finish(ToGrpcStatus(status));
  }

  HandOver callbacks_;  // one after another, on any of gRPC's threads or those for archives
  const ServiceParts& parts_;
  const grpc::CallbackServerContext& context_;
  CallRecord record_{parts_.sessions.counters, parts_.logger, "ImportScene"};
  const Caller caller_;
  const BlobsInScope blobs_;
  grpc::ByteBuffer* const response_bytes_;
  ArchiveClock clock_;
  const std::shared_ptr<IdleTimer> timer_;
  const std::shared_ptr<LiveCall> right_;
  grpc::ByteBuffer bytes_;
  std::unique_ptr<SceneImport> import_;
};

}  // namespace

grpc::ServerReadReactor<grpc::ByteBuffer>* PenumbraService::ImportScene(Context* context,
                                                                        Bytes* response) {
  const auto caller = parts_.guard.Admit(*context, "ImportScene");
  if (!caller.ok()) return new RefusedStream<grpc::ServerReadReactor<Bytes>>(caller.status());
  auto* reactor = new ImportReactor(parts_, *caller, context, response);
  reactor->Start();
  return reactor;
}

}  // namespace penumbra
