// An immutable snapshot of everything that shadows depend on, at one revision.
//
//   auto scene = Scene::Empty("studio");
//   auto next = scene->Apply({.upsert_instances = {table}, .upsert_lights = {lamp}});
//   if (!next.ok()) return next.status();   // `scene` is as it was
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/math/aabb.h"
#include "render/scene/area_light.h"
#include "render/scene/caster_tree.h"
#include "render/scene/content_hash.h"
#include "render/scene/instance.h"
#include "render/scene/receiver.h"
#include "render/scene/scene_limits.h"
#include "render/scene/surface_receivers.h"

namespace penumbra {

// Counts the commits of a scene: 0 is the empty scene, each commit adds one.
using Revision = uint64_t;

// A batch of upserts and removals; all of it commits or none of it does. An id may appear once in a
// kind. Removals of what is not there are errors.
struct SceneDelta {
  // The revision that the author saw; a commit on any other one is refused. Absent: any.
  std::optional<Revision> base_revision;
  std::vector<Instance> upsert_instances;
  std::vector<std::string> remove_instances;
  std::vector<AreaLight> upsert_lights;
  std::vector<std::string> remove_lights;
  std::vector<Receiver> upsert_receivers;
  std::vector<std::string> remove_receivers;
  // Upserts a receiver for each planar surface of the scene that the rest of the delta makes.
  std::optional<PlanarSurfaceRequest> receive_on_planar_surfaces;

  bool empty() const;
};

class Scene {
 public:
  // Id → object, in the order of ids. Objects and whole tables are shared between revisions.
  template <typename T>
  using Table = std::map<std::string, std::shared_ptr<const T>, std::less<>>;

  static std::shared_ptr<const Scene> Empty(std::string id);

  // The scene at the next revision.
  //
  // Errors  all name the field as "upsert_lights[2].edge_v":
  //         kInvalidArgument   NON_FINITE, OUT_OF_BOUNDS, BAD_ID, DUPLICATE_ID, ZERO_AREA, RANGE, …
  //         kNotFound          UNKNOWN_ID: removal of what is not there
  //         kFailedPrecondition  MISSING_INSTANCE, NOT_PLANAR: a receiver's instance, or triangle
  //         kAborted           STALE_BASE: base_revision is behind; the message has the current one
  //         kOutOfRange        FUTURE_BASE: base_revision is ahead
  //         kResourceExhausted QUOTA_…: a limit, with its value
  absl::StatusOr<std::shared_ptr<const Scene>> Apply(const SceneDelta& delta,
                                                     const SceneLimits& limits = {}) const;

  // The same content at another revision, for mirrors that do not see every commit on its own.
  std::shared_ptr<const Scene> WithRevision(Revision revision) const;

  const std::string& id() const { return id_; }
  Revision revision() const { return revision_; }
  // Of the content alone: equal for equal scenes whatever their history and their id.
  const ContentHash& content_hash() const { return content_hash_; }

  const Table<Instance>& instances() const { return *instances_; }
  // The same table; scenes between which no instance changed share it.
  std::shared_ptr<const Table<Instance>> shared_instances() const { return instances_; }
  // The instances that cast shadows, by place. Found on first use and kept with the table of
  // instances: scenes that share the one share the other. Any thread may ask.
  const CasterTree& casters() const { return casters_->Of(*instances_); }
  const Table<AreaLight>& lights() const { return *lights_; }
  const Table<Receiver>& receivers() const { return *receivers_; }

  // Null when there is none of that id.
  std::shared_ptr<const Instance> FindInstance(std::string_view instance_id) const;
  std::shared_ptr<const AreaLight> FindLight(std::string_view light_id) const;
  std::shared_ptr<const Receiver> FindReceiver(std::string_view receiver_id) const;

  // The receiver with its place in the world. Errors as for Apply's receivers; kNotFound.
  absl::StatusOr<ReceiverPatch> ResolveReceiver(std::string_view receiver_id) const;

  // Around all instances that have vertices, in world space.
  Aabb Bounds() const;

 private:
  Scene() = default;
  absl::Status AddSurfaceReceivers(const SceneDelta& delta, const SceneLimits& limits);

  std::string id_;
  Revision revision_ = 0;
  ContentHash content_hash_;
  std::shared_ptr<const Table<Instance>> instances_;
  std::shared_ptr<CasterTreeOnDemand> casters_;  // of `instances_`
  std::shared_ptr<const Table<AreaLight>> lights_;
  std::shared_ptr<const Table<Receiver>> receivers_;
};

// Around one placed instance, in world space; empty for an empty mesh.
Aabb WorldBounds(const Instance& instance);

// Errors  kInvalidArgument, BAD_ID: not 1 to 128 bytes of [A-Za-z0-9._-].
absl::Status CheckId(std::string_view id, std::string_view field_path);

}  // namespace penumbra
