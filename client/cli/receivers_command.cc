// penumbra receivers: the planar surfaces of a file, the largest first.
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/json_number.h"
#include "client/cli/json_text.h"
#include "client/cli/run_command.h"
#include "client/cli/surface_plan.h"
#include "render/scene/receiver_place.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

struct Listed {
  std::string id;
  FoundSurface surface;
  ReceiverPatch patch;

  Vec3 center() const { return patch.patch.At({0.5f, 0.5f}); }
};

Json ToJson(Vec3 v) { return {JsonNumber(v.x), JsonNumber(v.y), JsonNumber(v.z)}; }

Json ToJson(const Listed& listed) {
  const Parallelogram& patch = listed.patch.patch;
  return {{"id", listed.id},
          {"instance", listed.surface.instance_id},
          {"triangle", listed.surface.triangle},
          {"area_m2", listed.surface.area_m2},
          {"size_m", {glm::length(patch.edge_u), glm::length(patch.edge_v)}},
          {"center", ToJson(listed.center())},
          {"normal", ToJson(patch.normal())},
          {"width", listed.patch.width},
          {"height", listed.patch.height}};
}

std::string Line(const Listed& listed) {
  const Parallelogram& patch = listed.patch.patch;
  const Vec3 c = listed.center();
  const Vec3 n = glm::round(100.0f * patch.normal()) / 100.0f + Vec3(0.0f);  // no -0.00
  return absl::StrFormat(
      "%s  %.4g m2, %.4g x %.4g m, %dx%d texels, at (%.3g, %.3g, %.3g), facing (%.2f, %.2f, %.2f)",
      listed.id, listed.surface.area_m2, glm::length(patch.edge_u), glm::length(patch.edge_v),
      listed.patch.width, listed.patch.height, c.x, c.y, c.z, n.x, n.y, n.z);
}

absl::StatusOr<Listed> Place(const FoundSurface& surface, const InstanceTable& instances,
                             const PlanarSurfaceRequest& request) {
  const Receiver receiver{.id = SurfaceReceiverId(request.id_prefix, surface),
                          .shape = PlanarSurface{surface.instance_id, surface.triangle},
                          .texels_per_metre = request.texels_per_metre};
  auto patch = PlaceReceiver(receiver, instances.find(surface.instance_id)->second.get());
  if (!patch.ok()) return patch.status();
  return Listed{receiver.id, surface, *std::move(patch)};
}

}  // namespace

absl::Status Run(const ReceiversCommand& command, const Console& console, std::stop_token) {
  const auto imported = ImportScene(command.scene);
  if (!imported.ok()) return imported.status();
  const InstanceTable instances = TableOf(*imported);
  const auto request = SurfaceRequestFor(instances, command.min_area_m2, command.texels_per_metre);
  const size_t count = command.count > 0 ? command.count : std::numeric_limits<size_t>::max();
  Json list = Json::array();
  for (const FoundSurface& surface : FindPlanarSurfaces(instances, command.min_area_m2, count)) {
    const auto listed = Place(surface, instances, request);
    if (!listed.ok()) return listed.status();
    if (command.json) {
      list.push_back(ToJson(*listed));
    } else {
      console.out << Line(*listed) << '\n';
    }
  }
  for (const std::string& warning : imported->warnings) console.Note(warning);
  if (command.json) console.out << JsonText(Json{{"receivers", std::move(list)}}) << '\n';
  return absl::OkStatus();
}

}  // namespace penumbra
