// A client that speaks the wire format itself, message by message, for tests of the server.
//
//   WireClient client(server.address());
//   client.CreateScene("studio");
//   client.Upload(*mesh);
//   auto session = client.OpenSession("studio");
//   session->Commit(delta);
//   session->Subscribe(1, spec, 8);
//   ArtifactUpdate update = session->AwaitUpdate(1, [](const auto& u) { return IsFinal(u); });
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "penumbra/v1/service.grpc.pb.h"
#include "proto/convert/artifact_assembler.h"
#include "render/engine/engine.h"

namespace penumbra::testing {

// Long enough for a loaded machine under a sanitizer.
inline constexpr std::chrono::seconds kPatience{60};

// One stream. Reads happen in the calls below only: between them this client reads nothing.
class WireSession {
 public:
  using Stream = grpc::ClientReaderWriter<v1::SessionRequest, v1::SessionResponse>;

  explicit WireSession(v1::PenumbraService::Stub& stub);
  ~WireSession();

  void Send(const v1::SessionRequest& request);
  // The next response; none once the server has ended the call.
  std::optional<v1::SessionResponse> Read();
  // Reads on to the first response of this kind; updates that pass are assembled and kept.
  std::optional<v1::SessionResponse> ReadUntil(v1::SessionResponse::ResponseCase kind);
  // Why the call ended; waits for that.
  absl::Status End();
  // Ends the call from this side.
  void Cancel() { context_.TryCancel(); }

  v1::Welcome Hello(const std::string& scene_id, bool mirror_scene = false);
  // Says hello, mirroring, as one who knows the scene up to a revision.
  v1::Welcome Resume(const std::string& scene_id, const std::string& incarnation, Revision revision,
                     const std::string& content_hash);
  v1::CommitResult Commit(const SceneDelta& delta, const std::string& idempotency_key = {});
  v1::CommitResult Commit(const v1::SceneDelta& delta, const std::string& idempotency_key = {});
  absl::Status Subscribe(uint64_t id, const ArtifactSpec& spec, uint32_t credit);
  void GrantCredit(uint64_t id, uint32_t updates);
  void Acknowledge(uint64_t id);

  // Reads on to the first update of the subscription that `is_wanted`, acknowledging each update
  // and giving credit for another.
  ArtifactUpdate AwaitUpdate(uint64_t id,
                             const std::function<bool(const ArtifactUpdate&)>& is_wanted);

  // Of the updates read so far.
  uint64_t update_bytes() const { return update_bytes_; }
  uint64_t update_messages() const { return update_messages_; }
  uint64_t update_tiles() const { return update_tiles_; }

 private:
  v1::Welcome Greet(const v1::Hello& hello);
  void Keep(const v1::ArtifactUpdate& message);

  struct Reception {
    ArtifactAssembler assembler;
    std::deque<ArtifactUpdate> updates;
  };

  grpc::ClientContext context_;
  std::unique_ptr<Stream> stream_;
  uint64_t next_commit_id_ = 1;
  std::map<uint64_t, Reception> receptions_;
  uint64_t update_bytes_ = 0;
  uint64_t update_messages_ = 0;
  uint64_t update_tiles_ = 0;
};

class WireClient {
 public:
  // On a connection of its own.
  explicit WireClient(const std::string& address);

  v1::PenumbraService::Stub& stub() { return *stub_; }
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  absl::Status CreateScene(const std::string& scene_id);
  absl::Status DeleteScene(const std::string& scene_id);
  absl::StatusOr<std::vector<SceneInfo>> ListScenes();
  absl::StatusOr<SceneInfo> FindScene(const std::string& scene_id);
  v1::GetServerInfoResponse ServerInfo();
  absl::StatusOr<std::vector<std::string>> FindMissing(const std::vector<std::string>& hashes);

  // In messages of `chunk` bytes.
  absl::Status Upload(const Mesh& mesh, size_t chunk = 100'000);
  absl::StatusOr<v1::UploadBlobResponse> Upload(const std::vector<v1::UploadBlobRequest>& requests);
  absl::StatusOr<std::string> Download(const ContentHash& hash);

  std::unique_ptr<WireSession> OpenSession(const std::string& scene_id, bool mirror_scene = false);

 private:
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::PenumbraService::Stub> stub_;
};

bool IsFinal(const ArtifactUpdate& update);
// A final artifact, of this revision or later.
std::function<bool(const ArtifactUpdate&)> FinalAt(Revision revision);
const SoftShadowTexture& TextureOf(const ArtifactUpdate& update);

}  // namespace penumbra::testing
