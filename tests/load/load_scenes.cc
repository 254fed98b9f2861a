#include "tests/load/load_scenes.h"

#include "absl/strings/str_cat.h"
#include "client/session/remote_engine.h"
#include "tests/support/shapes.h"

namespace penumbra::load {

std::string SceneId(int number) { return absl::StrCat("load", number); }

Instance BoxOf(int client) {
  static const auto mesh = testing::MeshOf(testing::UnitBoxGeometry());
  return {.id = absl::StrCat("box", client), .mesh = mesh};
}

absl::StatusOr<ScenesBefore> MakeScenes(const std::string& server, int count) {
  const auto connected = RemoteEngine::Connect({.address = server});
  if (!connected.ok()) return connected.status();
  Engine& engine = **connected;
  ScenesBefore before;
  for (int scene = 0; scene < count; ++scene) {
    const std::string id = SceneId(scene);
    engine.DeleteScene(id).IgnoreError();  // of an earlier load
    if (auto status = engine.CreateScene(id); !status.ok()) return status;
    SceneDelta delta;
    delta.upsert_instances = {BoxOf(-1)};
    if (auto revision = engine.Commit(id, delta); !revision.ok()) return revision.status();
    auto snapshot = engine.Snapshot(id);
    if (!snapshot.ok()) return snapshot.status();
    before[id] = *snapshot;
  }
  return before;
}

}  // namespace penumbra::load
