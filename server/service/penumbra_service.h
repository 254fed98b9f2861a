// The calls of penumbra.v1.PenumbraService, one file each. They decode, hand over and answer.
//
// Requests arrive as bytes, not as messages: they are measured before they are parsed
// (bounded_parse.h), and what many sessions receive is strung together from shared slices.
#pragma once

#include <chrono>
#include <functional>

#include "penumbra/v1/server_info.pb.h"
#include "penumbra/v1/service.grpc.pb.h"
#include "render/engine/local_engine.h"
#include "server/log/logger.h"
#include "server/scene_store/scene_archives.h"
#include "server/security/call_guard.h"
#include "server/service/transfer_lanes.h"
#include "server/session/session.h"
#include "server/session/session_table.h"

namespace penumbra {

// What the calls work with. All of it outlives the service.
struct ServiceParts {
  const CallGuard& guard;  // every call asks it first
  SessionServices sessions;
  SessionTable& session_table;
  LocalEngine& engine;
  TransferLanes& transfers;
  std::function<v1::GlInfo()> gl_info;
  std::chrono::steady_clock::time_point started;
  Logger& logger;
  SceneArchives& archives;
};

namespace raw {
using Base = v1::PenumbraService::Service;
template <typename T>
using Scenes = v1::PenumbraService::WithRawCallbackMethod_CreateScene<
    v1::PenumbraService::WithRawCallbackMethod_ListScenes<
        v1::PenumbraService::WithRawCallbackMethod_DeleteScene<T>>>;
template <typename T>
using Infos = v1::PenumbraService::WithRawCallbackMethod_GetServerInfo<
    v1::PenumbraService::WithRawCallbackMethod_GetServerStatus<
        v1::PenumbraService::WithRawCallbackMethod_ListTechniques<T>>>;
template <typename T>
using Blobs = v1::PenumbraService::WithRawCallbackMethod_FindMissingBlobs<
    v1::PenumbraService::WithRawCallbackMethod_UploadBlob<
        v1::PenumbraService::WithRawCallbackMethod_DownloadBlob<T>>>;
template <typename T>
using Archives = v1::PenumbraService::WithRawCallbackMethod_ExportScene<
    v1::PenumbraService::WithRawCallbackMethod_ImportScene<T>>;
using Service =
    v1::PenumbraService::WithRawCallbackMethod_Session<Scenes<Infos<Blobs<Archives<Base>>>>>;
}  // namespace raw

class PenumbraService final : public raw::Service {
 public:
  explicit PenumbraService(const ServiceParts& parts) : parts_(parts) {}

  using Context = grpc::CallbackServerContext;
  using Bytes = grpc::ByteBuffer;

  grpc::ServerBidiReactor<Bytes, Bytes>* Session(Context* context) override;
  grpc::ServerUnaryReactor* CreateScene(Context*, const Bytes*, Bytes*) override;
  grpc::ServerUnaryReactor* ListScenes(Context*, const Bytes*, Bytes*) override;
  grpc::ServerUnaryReactor* DeleteScene(Context*, const Bytes*, Bytes*) override;
  grpc::ServerUnaryReactor* GetServerInfo(Context*, const Bytes*, Bytes*) override;
  grpc::ServerUnaryReactor* GetServerStatus(Context*, const Bytes*, Bytes*) override;
  grpc::ServerUnaryReactor* ListTechniques(Context*, const Bytes*, Bytes*) override;
  grpc::ServerUnaryReactor* FindMissingBlobs(Context*, const Bytes*, Bytes*) override;
  grpc::ServerReadReactor<Bytes>* UploadBlob(Context*, Bytes* response) override;
  grpc::ServerWriteReactor<Bytes>* DownloadBlob(Context*, const Bytes* request) override;
  grpc::ServerWriteReactor<Bytes>* ExportScene(Context*, const Bytes* request) override;
  grpc::ServerReadReactor<Bytes>* ImportScene(Context*, Bytes* response) override;

 private:
  const ServiceParts parts_;
};

}  // namespace penumbra
