// A client's mirror of a scene against a server that tells what it likes, and hands out what blobs
// it likes: the mirror's scene is always one whose hash was told, and after an error it stays what
// it was.

#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/session/blob_transfer.h"
#include "client/session/mirrored_scene.h"
#include "client/session/server_connection.h"
#include "penumbra/v1/session.pb.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/blob.h"
#include "render/scene/hashed_text.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/kit/target.h"
#include "tests/fuzz/targets/scene_rules.h"
#include "tests/fuzz/targets/small_studio.h"
#include "tests/support/hostile_server.h"
#include "tests/support/shapes.h"

namespace penumbra::fuzzing {
namespace {

// An update as it is; a delta of which the update, or the client's own commit, is told as a sound
// server does; a blob that the server has, or hands out for the studio's box; a broken connection.
enum Kind : uint8_t { kUpdate, kDelta, kOwn, kBlob, kFalseBlob, kDrop, kKinds };

std::string BytesOfBlob(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

class BlobServer final : public testing::HostileServer {
 public:
  BlobServer() : HostileServer([](Stream& stream, int) { return testing::Listen(stream); }) {}

  // By what a client asks for.
  void Give(std::map<std::string, std::string> blobs) {
    std::lock_guard lock(mutex_);
    blobs_ = std::move(blobs);
  }
  grpc::Status DownloadBlob(grpc::ServerContext*, const v1::DownloadBlobRequest* request,
                            grpc::ServerWriter<v1::DownloadBlobResponse>* writer) override {
    v1::DownloadBlobResponse response;
    {
      std::lock_guard lock(mutex_);
      const auto blob = blobs_.find(request->hash());
      if (blob == blobs_.end()) return {grpc::StatusCode::NOT_FOUND, "no such blob"};
      response.set_size_bytes(blob->second.size());
      response.set_data(blob->second);
    }
    writer->Write(response);
    return grpc::Status::OK;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::string> blobs_;
};

// Without pings, of which the server would have enough at some time.
std::unique_ptr<ServerConnection> Connected(const std::string& address) {
  constexpr double kLongerThanThis = 1e6;
  return ServerConnection::Open({.address = address, .keepalive_s = kLongerThanThis}).value();
}

class SceneUpdates final : public Target {
 public:
  SceneUpdates() : connection_(Connected(server_.address())) {
    WriteSceneLimits(SmallLimits(), limits_);
  }
  std::span<const StepKind> kinds() const override { return kinds_; }
  void Run(const Script& script) override;
  std::vector<Seed> Seeds() override;

 private:
  // What a revision may be, by what was told.
  using Told = std::set<std::pair<Revision, std::string>>;

  void GiveBlobs(const Script& script);
  void Take(const Step& step, MirroredScene& mirror);
  void Push(const v1::SceneUpdate& update, MirroredScene& mirror);
  void PushSound(const std::string& payload, bool is_own, MirroredScene& mirror);
  void Check(MirroredScene& mirror);

  const StepKind kinds_[kKinds] = {{"update", &v1::SceneUpdate::default_instance()},
                                   {"delta", &v1::SceneDelta::default_instance()},
                                   {"own", &v1::SceneDelta::default_instance()},
                                   {"blob"},
                                   {"false blob"},
                                   {"drop"}};
  BlobServer server_;
  const std::unique_ptr<ServerConnection> connection_;
  v1::Limits limits_;
  // Of the script that runs.
  KnownBlobs blobs_;
  Told told_;
  bool has_failed_ = false;
  std::shared_ptr<const Scene> last_;
};

void SceneUpdates::Run(const Script& script) {
  BlobTransfer blobs(*connection_, limits_);
  MirroredScene mirror("studio", blobs);
  GiveBlobs(script);
  last_ = mirror.Applied();
  told_ = {{0, ToProto(last_->content_hash())}};
  has_failed_ = false;
  for (const Step& step : script) {
    Take(step, mirror);
    Check(mirror);
  }
}

void SceneUpdates::GiveBlobs(const Script& script) {
  blobs_ = StudioBlobs();
  std::map<std::string, std::string> given;
  for (const auto& mesh : {StudioBox(), StudioSquare()}) {
    given[ToProto(mesh->id())] = BytesOfBlob(EncodeBlob(mesh->geometry()));
  }
  given[ToProto(StudioMask()->id())] = BytesOfBlob(EncodeBlob(*StudioMask()));
  for (const Step& step : script) {
    if (step.kind % kKinds == kBlob) {
      given[ToProto(HashOfBytes(step.payload))] = step.payload;
      const auto blob = DecodeBlob(std::as_bytes(std::span(step.payload)), SmallLimits());
      if (blob.ok()) blobs_.Add(*blob);
    } else if (step.kind % kKinds == kFalseBlob) {
      given[ToProto(StudioBox()->id())] = step.payload;
    }
  }
  server_.Give(std::move(given));
}

void SceneUpdates::Take(const Step& step, MirroredScene& mirror) {
  switch (step.kind % kKinds) {
    case kUpdate: {
      v1::SceneUpdate update;
      if (update.ParseFromString(step.payload)) Push(update, mirror);
      return;
    }
    case kDelta:
      return PushSound(step.payload, /*is_own=*/false, mirror);
    case kOwn:
      return PushSound(step.payload, /*is_own=*/true, mirror);
    case kDrop:
      return mirror.DropPieces();
  }
}

void SceneUpdates::Push(const v1::SceneUpdate& update, MirroredScene& mirror) {
  told_.insert({update.revision(), update.content_hash()});
  if (mirror.Push(update)) mirror.CatchUp();
}

// From where the mirror is; the first update that it gets is the whole scene.
void SceneUpdates::PushSound(const std::string& payload, bool is_own, MirroredScene& mirror) {
  v1::SceneDelta proto;
  if (!proto.ParseFromString(payload)) return;
  proto.clear_base_revision();
  auto delta = FromProto(proto, blobs_);
  if (!delta.ok()) return;
  const bool is_first = !is_own && !mirror.has_content();
  const auto before = is_first ? Scene::Empty("studio") : mirror.Applied();
  const auto after = before->Apply(*delta, SmallLimits());
  if (!after.ok()) return;
  const std::string hash = ToProto((*after)->content_hash());
  if (is_own) {
    told_.insert({(*after)->revision(), hash});
    mirror.PushOwn(*std::move(delta), (*after)->revision(), hash);
    return mirror.CatchUpOwn();
  }
  v1::SceneUpdate update;
  update.set_from_revision(before->revision());
  update.set_revision((*after)->revision());
  update.set_content_hash(hash);
  update.set_is_snapshot(is_first);
  *update.mutable_delta() = std::move(proto);
  Push(update, mirror);
}

void SceneUpdates::Check(MirroredScene& mirror) {
  const auto newest = mirror.Newest();
  Count(newest.ok());
  const auto applied = mirror.Applied();
  Require(told_.contains({applied->revision(), ToProto(applied->content_hash())}),
          "a mirror has a scene whose hash was told");
  if (applied != last_) RequireRules(*applied, SmallLimits());
  if (newest.ok()) {
    Require(!has_failed_, "what is out of step stays so");
    Require(*newest == applied, "the newest scene is the one that is applied");
    const auto point = mirror.pushed_point();
    Require(!point || (point->revision == applied->revision() &&
                       point->content_hash == ToProto(applied->content_hash())),
            "all that was pushed is applied");
  } else {
    Require(!has_failed_ || applied == last_, "after an error nothing changes");
    Require(newest.status().code() != absl::StatusCode::kInternal &&
                newest.status().code() != absl::StatusCode::kUnavailable,
            "an error says what is wrong: " + newest.status().ToString());
    Require(newest.status().message().size() < 4'096, "an error in fewer words");
    has_failed_ = true;
  }
  last_ = applied;
}

Step DeltaStep(uint8_t kind, const SceneDelta& delta) {
  return {kind, ToProto(delta).SerializeAsString()};
}

v1::SceneUpdate Snapshot(Revision revision) {
  const auto scene = Scene::Empty("studio")->Apply(StudioDelta(), SmallLimits()).value();
  v1::SceneUpdate update;
  update.set_revision(revision);
  update.set_content_hash(ToProto(scene->content_hash()));
  update.set_is_snapshot(true);
  *update.mutable_delta() = ToProto(StudioDelta());
  return update;
}

Step StepOf(const v1::SceneUpdate& update) { return {kUpdate, update.SerializeAsString()}; }

// An object a message.
Script SnapshotInPieces(Revision revision) {
  v1::SceneUpdate update = Snapshot(revision);
  Script script;
  const auto pieces = ToProtoPieces(StudioDelta(), 1);
  for (size_t i = 0; i < pieces.size(); ++i) {
    *update.mutable_delta() = pieces[i];
    update.set_is_continued(i + 1 < pieces.size());
    script.push_back(StepOf(update));
    update.set_is_snapshot(false);
  }
  return script;
}

std::vector<Seed> SceneUpdates::Seeds() {
  const std::string ball = BytesOfBlob(EncodeBlob(testing::BallGeometry(5, 3)));
  SceneDelta with_ball = BoxAt(1);
  with_ball.upsert_instances[0].mesh = testing::MeshOf(testing::BallGeometry(5, 3));
  const std::string box = BytesOfBlob(EncodeBlob(StudioBox()->geometry()));
  const Step studio = DeltaStep(kDelta, StudioDelta());
  Script broken = SnapshotInPieces(3);
  broken.resize(4);
  broken.push_back({kDrop, ""});
  broken.push_back(StepOf(Snapshot(3)));
  return {
      {"snapshot", {StepOf(Snapshot(7)), DeltaStep(kDelta, BoxAt(1))}},
      {"pieces", SnapshotInPieces(7)},
      {"broken", broken},
      {"own", {studio, DeltaStep(kOwn, BoxAt(1)), DeltaStep(kDelta, BoxAt(2))}},
      {"ball", {{kBlob, ball}, studio, DeltaStep(kDelta, with_ball)}},
      {"another box", {{kFalseBlob, box}, studio, DeltaStep(kOwn, BoxAt(1))}},
      {"false box", {{kFalseBlob, ball}, studio, DeltaStep(kDelta, BoxAt(1))}},
  };
}

}  // namespace

Target& TheTarget() {
  static SceneUpdates target;
  return target;
}

}  // namespace penumbra::fuzzing
