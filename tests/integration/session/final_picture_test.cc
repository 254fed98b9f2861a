// The preview and the final picture by way of a server.
#include "render/artifact/attenuation_ldi.h"
#include "render/scene/field_error.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {
namespace {

// The box on a floor that casts and is seen.
SceneDelta StudioOnAFloor(Vec3 box_position = Vec3(0, 0.5f, 0)) {
  SceneDelta delta = Studio(box_position);
  delta.upsert_instances.push_back({.id = "ground",
                                    .mesh = MeshOf(UnitSquareGeometry()),
                                    .world_from_mesh = Placed(Vec3(0), Vec3(2, 1, 2))});
  return delta;
}

ArtifactSpec LayersSpec() {
  return {LayeredAttenuationParams{.samples = 64, .resolution = 200}, "lamp"};
}

ArtifactSpec PictureSpec(uint32_t side = 256, uint32_t samples = 64) {
  ArtifactSpec spec{CoherentRaytraceParams{.samples = samples}, "lamp"};
  spec.points = PicturePixels{
      .camera = {.eye = {2, 3, 3}, .target = {0, 0.3f, 0}}, .width = side, .height = side};
  return spec;
}

const AttenuationLdi& LdiOf(const Artifact& artifact) {
  return std::get<AttenuationLdi>(artifact.payload);
}
const ViewShadow& ViewOf(const Artifact& artifact) {
  return std::get<ViewShadow>(artifact.payload);
}

std::shared_ptr<const Artifact> ComputedHere(const SceneDelta& delta, const ArtifactSpec& spec) {
  LocalEngine local(LocalEngineOptions{});
  EXPECT_TRUE(local.CreateScene("s").ok());
  EXPECT_TRUE(local.Commit("s", delta).ok());
  return ComputeOnce(local, "s", spec).value();
}

TEST_F(RemoteEngineTest, LayersArriveAsTheyWereComputed) {
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("s").ok());
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor()).ok());
  Inbox inbox;
  const auto subscription = engine->Subscribe("s", LayersSpec(), inbox.callback());
  ASSERT_TRUE(subscription.ok()) << subscription.status();
  auto update = inbox.WaitForFinal(1);
  ASSERT_TRUE(update);
  const auto expected = ComputedHere(StudioOnAFloor(), LayersSpec());
  for (size_t f = 0; f < LdiOf(*expected).faces.size(); ++f) {
    EXPECT_EQ(LdiOf(*update->artifact).faces[f].depths, LdiOf(*expected).faces[f].depths);
    EXPECT_EQ(LdiOf(*update->artifact).faces[f].counts, LdiOf(*expected).faces[f].counts);
  }
  EXPECT_EQ(update->artifact->header.light_samples, expected->header.light_samples);
  EXPECT_EQ(update->artifact->header.receiver_id, "");
  // Under the box it is dark, beside it lit; the first pass said so too.
  const ArtifactUpdate first = inbox.updates().front();
  for (const auto& artifact : {first.artifact, update->artifact}) {
    EXPECT_EQ(Visibility(*artifact, Vec3(0, 0, 0), Vec3(0, 1, 0)), 0.0f);
    EXPECT_EQ(Visibility(*artifact, Vec3(1.8f, 0, 1.8f), Vec3(0, 1, 0)), 1.0f);
  }
  // An edit brings the layers of what it left.
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor(Vec3(0.7f, 0.5f, 0))).ok());
  update = inbox.WaitForFinal(2);
  ASSERT_TRUE(update);
  const auto moved = ComputedHere(StudioOnAFloor(Vec3(0.7f, 0.5f, 0)), LayersSpec());
  EXPECT_EQ(LdiOf(*update->artifact).faces[0].counts, LdiOf(*moved).faces[0].counts);
}

TEST_F(RemoteEngineTest, AFinalPictureComesTileByTile) {
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("s").ok());
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor()).ok());
  const ArtifactSpec spec = PictureSpec(768, 256);
  Inbox inbox;
  const auto subscription = engine->Subscribe("s", spec, inbox.callback());
  ASSERT_TRUE(subscription.ok()) << subscription.status();
  const auto update = inbox.WaitForFinal(1);
  ASSERT_TRUE(update);
  const auto expected = ComputedHere(StudioOnAFloor(), spec);
  const ViewShadow &found = ViewOf(*update->artifact), &here = ViewOf(*expected);
  EXPECT_EQ(found.visibility.counts, here.visibility.counts);
  EXPECT_EQ(found.radiance->texels, here.radiance->texels);
  EXPECT_EQ(*found.coverage, *here.coverage);
  EXPECT_EQ(found.progress.fraction_done, 1.0);
  EXPECT_GT(found.progress.rays_traced, 1000u);
  double done = 0;
  for (const ArtifactUpdate& one : inbox.updates()) {
    ASSERT_TRUE(one.artifact);
    const ViewShadow& view = ViewOf(*one.artifact);
    EXPECT_GE(view.progress.fraction_done, done);
    done = view.progress.fraction_done;
    EXPECT_LE(view.coverage->CountInside(), here.coverage->CountInside());
    // What is there is as it will be.
    for (size_t i = 0; i < view.visibility.counts.size(); ++i) {
      if (!view.coverage->At(i)) continue;
      ASSERT_EQ(view.visibility.counts[i], here.visibility.counts[i]);
    }
  }
}

TEST_F(RemoteEngineTest, APartOfAPictureIsThatPart) {
  const auto whole = ComputedHere(StudioOnAFloor(), PictureSpec());
  ArtifactSpec spec = PictureSpec();
  auto& picture = std::get<PicturePixels>(*spec.points);
  picture.crop = {.x = 70, .y = 90, .width = 60, .height = 40};
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("s").ok());
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor()).ok());
  const auto part = ComputeOnce(*engine, "s", spec);
  ASSERT_TRUE(part.ok()) << part.status();
  EXPECT_EQ(ViewOf(**part).visibility.width, 60u);
  // Jitter goes by the place in what was asked for, so that counts are alike, not equal.
  double difference = 0;
  for (uint32_t j = 0; j < 40; ++j) {
    for (uint32_t i = 0; i < 60; ++i) {
      difference += std::abs(ViewOf(**part).visibility.Fraction(i, j) -
                             ViewOf(*whole).visibility.Fraction(70 + i, 90 + j));
    }
  }
  EXPECT_LT(difference / 2400, 0.02);
}

// A picture that would take minutes.
ArtifactSpec EndlessSpec(uint64_t seed = 1) {
  ArtifactSpec spec = PictureSpec(2048, 1024);
  std::get<CoherentRaytraceParams>(spec.params).coherence = false;
  std::get<CoherentRaytraceParams>(spec.params).seed = seed;
  return spec;
}

bool HasArtifact(const ArtifactUpdate& update) { return update.artifact != nullptr; }

TEST_F(RemoteEngineTest, PicturesWithoutEndHoldUpNothingElse) {
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("s").ok());
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor()).ok());
  Inbox endless;
  std::vector<std::unique_ptr<Subscription>> subscriptions;
  const auto follow = [&](const ArtifactSpec& spec, Inbox& inbox) {
    auto subscription = engine->Subscribe("s", spec, inbox.callback());
    ASSERT_TRUE(subscription.ok()) << subscription.status();
    subscriptions.push_back(*std::move(subscription));
  };
  for (uint64_t seed = 1; seed <= 3; ++seed) follow(EndlessSpec(seed), endless);
  ASSERT_TRUE(endless.WaitFor(HasArtifact));
  for (const ArtifactSpec& spec : {FloorSpec(), LayersSpec()}) {
    Inbox inbox;
    follow(spec, inbox);
    EXPECT_TRUE(inbox.WaitForFinal(1)) << InfoOf(spec.params).name;
    subscriptions.pop_back();
  }
}

// One picture is computed at a time, so another comes only where the first has stopped.
TEST_F(RemoteEngineTest, C16WorkStopsWhenNobodyWaitsForIt) {
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("s").ok());
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor()).ok());
  Inbox endless;
  auto subscription = engine->Subscribe("s", EndlessSpec(), endless.callback());
  ASSERT_TRUE(subscription.ok()) << subscription.status();
  ASSERT_TRUE(endless.WaitFor(HasArtifact));
  engine.reset();  // goes away in the middle
  const auto other = Connect();
  Inbox inbox;
  const auto soon = other->Subscribe("s", PictureSpec(64), inbox.callback());
  ASSERT_TRUE(soon.ok()) << soon.status();
  EXPECT_TRUE(inbox.WaitForFinal(1));
}

TEST_F(RemoteEngineTest, EachLightHasItsLayersByOneCall) {
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("s").ok());
  SceneDelta delta = StudioOnAFloor();
  delta.upsert_lights.push_back({.id = "bulb", .shape = PointLight{.position = {1, 2, 0}}});
  ASSERT_TRUE(engine->Commit("s", delta).ok());
  const auto ignore = [](const ArtifactSpec&, const ArtifactUpdate&, const UpdateTraffic&) {};
  const auto all = engine->SubscribeEach("s", {.params = LayeredAttenuationParams{}}, ignore);
  ASSERT_TRUE(all.ok()) << all.status();
  ASSERT_EQ(all->size(), 2u);
  EXPECT_EQ((*all)[0].spec.light_id, "bulb");
  EXPECT_EQ((*all)[0].spec.receiver_id, "");
  const auto refused = engine->SubscribeEach(
      "s", {.params = LayeredAttenuationParams{}, .receiver_ids = {"floor"}}, ignore);
  EXPECT_EQ(ErrorReason(refused.status()), "UNEXPECTED_FIELD") << refused.status();
  const auto pictures = engine->SubscribeEach(
      "s", {.params = CoherentRaytraceParams{.samples = 4}, .points = PictureSpec(16).points},
      ignore);
  ASSERT_TRUE(pictures.ok()) << pictures.status();
  EXPECT_EQ((*pictures)[1].spec.points, PictureSpec(16).points);
}

TEST_F(RemoteEngineTest, WhatCannotBeIsRefusedByName) {
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("s").ok());
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor()).ok());
  const auto fault = [&](const ArtifactSpec& spec) {
    const absl::Status status = ComputeOnce(*engine, "s", spec).status();
    return ErrorFieldPath(status) + " " + ErrorReason(status);
  };
  ArtifactSpec spec = LayersSpec();
  std::get<LayeredAttenuationParams>(spec.params).tolerance = -1;
  EXPECT_EQ(fault(spec), "layered_attenuation.tolerance RANGE");
  std::get<LayeredAttenuationParams>(spec.params) = {.resolution = 100'000};
  EXPECT_EQ(fault(spec), "layered_attenuation.resolution RANGE");
  std::get<LayeredAttenuationParams>(spec.params) = {.max_layers = 1};
  EXPECT_EQ(fault(spec), "layered_attenuation.max_layers QUOTA_LDI_LAYERS");
  spec.params = LayeredAttenuationParams{.source = DepthMethod::kGl};
  EXPECT_EQ(fault(spec), "layered_attenuation.source NO_GL");
  spec = PictureSpec();
  spec.light_id = std::string(kAllLights);
  EXPECT_EQ(fault(spec), "light_id RANGE");
  spec = PictureSpec();
  spec.points = LightmapTexels{"box", 8, 8};
  EXPECT_EQ(fault(spec), "points.lightmap.instance_id MISSING_UV");
  spec = PictureSpec();
  std::get<CoherentRaytraceParams>(spec.params).output = RadianceFormat::kUnorm8;
  EXPECT_EQ(fault(spec), "coherent_raytrace.output RANGE");
}

// Nothing is wrong with them, and nothing comes out that is no number.
TEST_F(RemoteEngineTest, OddPlacesAreComputed) {
  auto engine = Connect();
  ASSERT_TRUE(engine->CreateScene("s").ok());
  ASSERT_TRUE(engine->Commit("s", StudioOnAFloor()).ok());
  ArtifactSpec spec = PictureSpec(64);
  auto& picture = std::get<PicturePixels>(*spec.points);
  picture.camera = {.eye = {0, 0.5f, 0}, .target = {1, 0.5f, 0}};  // inside the box
  EXPECT_EQ(ViewOf(**ComputeOnce(*engine, "s", spec)).coverage->CountInside(), 64u * 64);
  picture.camera = {.eye = {0, 5, 0}, .target = {0, 9, 0}, .fov_y_deg = 20};  // at nothing
  const auto nothing = ComputeOnce(*engine, "s", spec);
  ASSERT_TRUE(nothing.ok()) << nothing.status();
  EXPECT_EQ(ViewOf(**nothing).coverage->CountInside(), 0u);
  // A light inside the box.
  ASSERT_TRUE(engine
                  ->Commit("s", {.upsert_lights = {{.id = "lamp",
                                                    .shape = SphereLight{.center = {0, 0.5f, 0},
                                                                         .radius = 0.1f}}}})
                  .ok());
  const auto layers = ComputeOnce(*engine, "s", LayersSpec());
  ASSERT_TRUE(layers.ok()) << layers.status();
  EXPECT_EQ(Visibility(**layers, Vec3(1.5f, 0, 0), Vec3(0, 1, 0)), 0.0f);
  const auto dark = ComputeOnce(*engine, "s", PictureSpec(64));
  ASSERT_TRUE(dark.ok()) << dark.status();
  for (const Vec3& texel : ViewOf(**dark).radiance->texels) EXPECT_TRUE(IsFinite(texel));
}

}  // namespace
}  // namespace penumbra::testing
