// What a result's name depends on, and what not.
#include "render/engine/result_key.h"

#include <gtest/gtest.h>

#include <functional>
#include <initializer_list>
#include <optional>
#include <set>
#include <vector>

#include "render/artifact/artifact_size.h"
#include "render/engine/compute_once.h"
#include "render/engine/local_engine.h"
#include "tests/support/shapes.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra::testing {
namespace {

using ScenePtr = std::shared_ptr<const Scene>;

class ResultKeyTest : public ::testing::Test {
 protected:
  static ScenePtr After(const ScenePtr& scene, const SceneDelta& delta) {
    auto next = scene->Apply(delta);
    EXPECT_TRUE(next.ok()) << next.status();
    return *next;
  }
  static SceneDelta Changed(const ScenePtr& scene, const std::function<void(Instance&)>& change) {
    SceneDelta delta;
    delta.upsert_instances = {*scene->FindInstance("box")};
    change(delta.upsert_instances[0]);
    return delta;
  }
  ContentHash KeyOf(const ScenePtr& scene, const ArtifactSpec& spec = LampOnFloor()) {
    const auto key = keys_.Of(*scene, spec);
    EXPECT_TRUE(key.has_value());
    return key.value_or(ContentHash());
  }

  ResultKeys keys_;
  const ScenePtr scene_ = After(Scene::Empty("s"), LampAndFloor());
};

TEST_F(ResultKeyTest, IsTheSameForWhatChangesNoTexel) {
  const ContentHash key = KeyOf(scene_);
  EXPECT_EQ(KeyOf(After(Scene::Empty("other"), LampAndFloor())), key);
  EXPECT_EQ(KeyOf(After(scene_, {})), key) << "another revision";
  EXPECT_EQ(KeyOf(After(scene_, Changed(scene_,
                                        [](Instance& box) {
                                          box.color = {1, 0, 0};
                                        }))),
            key);
  SceneDelta more;
  more.upsert_lights = {{.id = "other", .shape = PointLight{.position = {0, 5, 0}}}};
  more.upsert_receivers = {*scene_->FindReceiver("floor")};
  more.upsert_receivers[0].id = "other";
  EXPECT_EQ(KeyOf(After(scene_, more)), key);
  ArtifactSpec hurried = LampOnFloor();
  hurried.time_budget_ms = 5;
  EXPECT_EQ(KeyOf(scene_, hurried), key);
}

// All different, each said to be what it is.
class DifferentKeys {
 public:
  void Add(const char* what, const std::optional<ContentHash>& key) {
    ASSERT_TRUE(key) << what;
    EXPECT_TRUE(keys_.insert(*key).second) << what;
  }

 private:
  std::set<ContentHash> keys_;
};

TEST_F(ResultKeyTest, IsAnotherForEachSurface) {
  DifferentKeys keys;
  keys.Add("as it was", KeyOf(scene_));
  const auto add = [&](const char* what, const std::function<void(Instance&)>& change) {
    keys.Add(what, KeyOf(After(scene_, Changed(scene_, change))));
  };
  add("place", [](Instance& box) { box.world_from_mesh[3].x += 1e-3f; });
  add("mesh", [](Instance& box) { box.mesh = MeshOf(UnitSquareGeometry()); });
  add("casts", [](Instance& box) { box.casts = false; });
  add("receives", [](Instance& box) { box.receives = false; });
  add("cutoff", [](Instance& box) { box.alpha_cutoff = 0.25f; });
  SceneDelta gone;
  gone.remove_instances = {"box"};
  keys.Add("removal", KeyOf(After(scene_, gone)));
  gone.upsert_instances = {*scene_->FindInstance("box")};
  gone.upsert_instances[0].id = "another-box";
  keys.Add("id", KeyOf(After(scene_, gone)));
}

TEST_F(ResultKeyTest, IsAnotherForEachLightReceiverAndSpec) {
  DifferentKeys keys;
  keys.Add("as it was", KeyOf(scene_));
  SceneDelta light;
  light.upsert_lights = {
      {.id = "lamp", .shape = SphereLight{.center = {0, 2, 0}, .radius = 0.123f}}};
  keys.Add("light", KeyOf(After(scene_, light)));
  SceneDelta receiver;
  receiver.upsert_receivers = {*scene_->FindReceiver("floor")};
  receiver.upsert_receivers[0].width += 1;
  keys.Add("receiver", KeyOf(After(scene_, receiver)));
  keys.Add("seed", KeyOf(scene_, LampOnFloor(2)));
  ArtifactSpec all = LampOnFloor();
  all.light_id = std::string(kAllLights);
  keys.Add("all lights", KeyOf(scene_, all));
  SceneDelta second;
  second.upsert_lights = {{.id = "second", .shape = PointLight{.position = {0, 5, 0}}}};
  keys.Add("one light more", KeyOf(After(scene_, second), all));
}

// They are surfaces there, and drawn.
TEST_F(ResultKeyTest, WithoutAReceiverThoseThatStandByThemselvesCount) {
  const ArtifactSpec spec{.params = LayeredAttenuationParams{}, .light_id = "lamp"};
  DifferentKeys keys;
  keys.Add("as it was", KeyOf(scene_, spec));
  SceneDelta wall;
  wall.upsert_receivers = {*scene_->FindReceiver("floor")};
  wall.upsert_receivers[0].id = "wall";
  keys.Add("another", KeyOf(After(scene_, wall), spec));
  wall.upsert_receivers[0].id = "floor";
  wall.upsert_receivers[0].width += 1;
  keys.Add("changed", KeyOf(After(scene_, wall), spec));
  SceneDelta gone;
  gone.remove_receivers = {"floor"};
  keys.Add("removed", KeyOf(After(scene_, gone), spec));
}

// Whatever a technique reads of a scene: where the keys of two scenes are equal, so are artifacts.
class EqualKeysTest : public ResultKeyTest, public ::testing::WithParamInterface<int> {
 protected:
  static std::vector<ArtifactSpec> Specs() {
    const PicturePixels picture{
        .camera = {.eye = {2, 2, 2}, .target = {0, 0, 0}}, .width = 24, .height = 16};
    return {
        LampOnFloor(),
        {.params = LayeredAttenuationParams{.samples = 4, .resolution = 32}, .light_id = "lamp"},
        {.params = CoherentRaytraceParams{.samples = 2}, .light_id = "lamp", .points = picture},
        {.params = ShadowWidthParams{.resolution = 32}, .light_id = "lamp"},
        {.params = ShadowVolumeParams{.resolution = 32}, .light_id = "lamp"}};
  }
  static std::vector<SceneDelta> Edits(const ScenePtr& scene) {
    std::vector<SceneDelta> edits;
    for (const auto& change : std::initializer_list<std::function<void(Instance&)>>{
             [](Instance& box) {
               box.color = {1, 0, 0};
             },
             [](Instance& box) { box.receives = false; }, [](Instance& box) { box.casts = false; },
             [](Instance& box) { box.world_from_mesh[3].x += 0.1f; }}) {
      edits.push_back(Changed(scene, change));
    }
    SceneDelta receiver;
    receiver.upsert_receivers = {FloorReceiver("wall", 0.5f, 8)};
    edits.push_back(receiver);
    SceneDelta on_box;
    on_box.upsert_receivers = {
        {.id = "face", .shape = PlanarSurface{.instance_id = "box", .triangle = 0}}};
    edits.push_back(on_box);
    SceneDelta light;
    light.upsert_lights = {{.id = "second", .shape = PointLight{.position = {1, 2, 0}}}};
    edits.push_back(light);
    return edits;
  }
  // All that it says of surfaces.
  static std::vector<float> Probes(const ScenePtr& scene, const ArtifactSpec& spec) {
    LocalEngine engine;
    EXPECT_TRUE(engine.RestoreScene(scene).ok());
    const auto artifact = ComputeOnce(engine, scene->id(), spec);
    EXPECT_TRUE(artifact.ok()) << artifact.status();
    std::vector<float> found;
    if (const ShadowTexels* texels = TexelsOf((*artifact)->payload)) {
      found.assign(texels->visibility.counts.begin(), texels->visibility.counts.end());
    }
    for (float x = -1; x <= 1; x += 0.125f) {
      for (const Vec3 point : {Vec3(x, 0, 0.1f), Vec3(x, 0.9f, 0), Vec3(x, 0.3f, 0.4f)}) {
        found.push_back(Visibility(**artifact, point, Vec3(0, 1, 0)));
      }
    }
    found.push_back(static_cast<float>(BytesOf(**artifact)));
    return found;
  }
};

TEST_P(EqualKeysTest, HaveEqualArtifacts) {
  const ArtifactSpec spec = Specs()[static_cast<size_t>(GetParam())];
  const std::vector<float> before = Probes(scene_, spec);
  size_t equal = 0;
  for (const SceneDelta& edit : Edits(scene_)) {
    const ScenePtr edited = After(scene_, edit);
    if (KeyOf(edited, spec) != KeyOf(scene_, spec)) continue;
    ++equal;
    EXPECT_EQ(Probes(edited, spec), before);
  }
  EXPECT_GE(equal, 3u) << "the colour, the face and the second light at least";
}

INSTANTIATE_TEST_SUITE_P(Techniques, EqualKeysTest, ::testing::Range(0, 5));

TEST_F(ResultKeyTest, ThereIsNoneForWhatIsNotThere) {
  ArtifactSpec spec = LampOnFloor();
  spec.light_id = "nobody";
  EXPECT_FALSE(keys_.Of(*scene_, spec));
  spec = LampOnFloor();
  spec.receiver_id = "nowhere";
  EXPECT_FALSE(keys_.Of(*scene_, spec));
}

TEST_F(ResultKeyTest, AnArtifactOfTheVerySceneStaysTheObjectThatItIs) {
  const auto artifact = std::make_shared<const Artifact>(LabelledArtifact(*scene_, 0, true));
  EXPECT_EQ(AsComputedOn(*scene_, artifact), artifact);
  const ScenePtr later = After(scene_, {});
  const auto as = AsComputedOn(*later, artifact);
  EXPECT_EQ(as->header.revision, 2u);
  EXPECT_EQ(as->header.scene_hash, later->content_hash());
  EXPECT_TRUE(as->header.is_final);
}

}  // namespace
}  // namespace penumbra::testing
