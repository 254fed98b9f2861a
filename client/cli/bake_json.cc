#include <nlohmann/json.hpp>

#include "client/cli/bake_files.h"
#include "client/cli/json_number.h"
#include "client/cli/light_json.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(Vec3 v) { return {JsonNumber(v.x), JsonNumber(v.y), JsonNumber(v.z)}; }

// A number or a truth value where the text is one.
Json ParameterToJson(const std::string& text) {
  Json value = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  return value.is_number() || value.is_boolean() ? value : Json(text);
}

Json ToJson(const std::map<std::string, std::string>& parameters) {
  Json json = Json::object();
  for (const auto& [name, text] : parameters) json[name] = ParameterToJson(text);
  return json;
}

Json ToJson(const LightSample& sample) {
  return {{sample.at_infinity ? "direction" : "position", ToJson(sample.point)},
          {"weight", JsonNumber(sample.weight)}};
}

Json ReceiverToJson(const std::string& id, const ReceiverPatch& receiver) {
  return {{"id", id},
          {"origin", ToJson(receiver.patch.origin)},
          {"edge_u", ToJson(receiver.patch.edge_u)},
          {"edge_v", ToJson(receiver.patch.edge_v)},
          {"width", receiver.width},
          {"height", receiver.height},
          {"two_sided", receiver.two_sided},
          {"reflectance", ToJson(receiver.reflectance)}};
}

Json ToJson(const PixelRect& rect) {
  return {{"x", rect.x}, {"y", rect.y}, {"width", rect.width}, {"height", rect.height}};
}

Json ToJson(const PicturePixels& picture) {
  return {{"camera",
           {{"eye", ToJson(picture.camera.eye)},
            {"target", ToJson(picture.camera.target)},
            {"up", ToJson(picture.camera.up)},
            {"fov_y_deg", JsonNumber(picture.camera.fov_y_deg)}}},
          {"width", picture.width},
          {"height", picture.height},
          {"part", ToJson(picture.part())}};
}

Json ToJson(const LightmapTexels& lightmap) {
  return {
      {"instance", lightmap.instance_id}, {"width", lightmap.width}, {"height", lightmap.height}};
}

Json ToJson(const GivenPoints&) { return "as they were given"; }

// How many pixels a view has, and where it looks from.
Json ToJson(const LightView& view) {
  const DVec3 n = view.frame.axes.n, eye = view.frame.ToWorld(view.eye);
  return {{"from_infinity", view.from_infinity},
          {"eye", ToJson(Vec3(view.from_infinity ? view.frame.origin : eye))},
          {"looks_along", ToJson(Vec3(n))},
          {"width", view.width},
          {"height", view.height}};
}

Json ToJson(const LdiFace& face) {
  Json json = ToJson(face.view);
  json["layers"] = face.layer_count();
  return json;
}

// With all that it takes to find a point's texel.
Json PlaceToJson(const LightView& view) {
  Json json = ToJson(view);
  const Window& window = view.window;
  json["axis_s"] = ToJson(Vec3(view.frame.axes.s));
  json["axis_t"] = ToJson(Vec3(view.frame.axes.t));
  json["window"] = {window.min.x, window.min.y, window.max.x, window.max.y};
  return json;
}

Json ToJson(const ShadowWidthFace& face) {
  Json json = PlaceToJson(face.view);
  const Window& told = face.window;
  json["tells_of"] = {told.min.x, told.min.y, told.max.x, told.max.y};
  json["layers"] = face.far ? 2 : 1;
  return json;
}

Json ToJson(const ShadowVolume& volume) {
  Json faces = Json::array();
  for (const VolumeFace& face : volume.faces) {
    faces.push_back(PlaceToJson(face.map.view));
    faces.back()["borders_on"] = face.border == VolumeBorder::kNothing ? "nothing" : "others";
  }
  Json json = {{"kind", kVolumeKindNames[static_cast<size_t>(volume.kind)]},
               {"content", volume.content.hex()},
               {"triangles", volume.triangle_count()},
               {"vertices", volume.vertices.size()},
               {"faces", std::move(faces)}};
  if (!volume.instance_id.empty()) json["instance"] = volume.instance_id;
  return json;
}

size_t InsideCount(const ShadowTexels& texels) {
  return texels.coverage ? texels.coverage->CountInside() : texels.visibility.counts.size();
}

// What each kind of artifact adds.
struct Particulars {
  const ArtifactHeader& header;
  Json& json;

  void operator()(const SoftShadowTexture& texture) const {
    json["receiver"] = ReceiverToJson(header.receiver_id, texture.receiver);
    json["inside_texels"] = InsideCount(texture);
    json["sample_count"] = texture.visibility.sample_count;
  }
  void operator()(const ViewShadow& view) const {
    std::visit([&](const auto& points) { json["points"] = ToJson(points); }, view.points);
    json["inside_texels"] = InsideCount(view);
    json["sample_count"] = view.visibility.sample_count;
    json["rays_traced"] = view.progress.rays_traced;
  }
  void operator()(const AttenuationLdi& ldi) const {
    json["faces"] = Json::array();
    for (const LdiFace& face : ldi.faces) json["faces"].push_back(ToJson(face));
    json["sample_count"] = ldi.sample_count;
    json["tolerance"] = JsonNumber(ldi.tolerance);
  }
  void operator()(const ShadowVolumeMesh& mesh) const {
    json["volumes"] = Json::array();
    for (const auto& volume : mesh.volumes) json["volumes"].push_back(ToJson(*volume));
    json["bias_px"] = JsonNumber(mesh.bias_px);
    json["edge_fraction"] = JsonNumber(mesh.edge_fraction);
  }
  void operator()(const ShadowWidthMap& map) const {
    json["faces"] = Json::array();
    for (const ShadowWidthFace& face : map.faces) json["faces"].push_back(ToJson(face));
    if (map.c_scale) json["c_scale"] = JsonNumber(*map.c_scale);
    json["c_bias"] = JsonNumber(map.c_bias);
  }
};

}  // namespace

std::string BakeJson(const BakeRecord& record, float exposure) {
  const ArtifactHeader& header = record.artifact.header;
  Json samples = Json::array();
  for (const LightSample& sample : header.light_samples) samples.push_back(ToJson(sample));
  Json timings = Json::object();
  for (const auto& [stage, ms] : header.timings_ms) timings[stage] = ms;
  timings["wall"] = record.wall_ms;

  Json json = {
      {"technique", header.technique}, {"parameters", ToJson(header.parameters)},
      {"scene", record.scene},         {"scene_hash", header.scene_hash.hex()},
      {"revision", header.revision},   {"light", LightToJson(LightOf(record.artifact.payload))}};
  std::visit(Particulars{header, json}, record.artifact.payload);
  json["error_estimate"] = header.error_estimate;
  json["light_samples"] = std::move(samples);
  json["timings_ms"] = std::move(timings);
  for (const std::string& extension : ExtensionsOf(record.artifact.payload)) {
    if (extension != "json") json["files"][extension] = record.name + "." + extension;
  }
  if (json["files"].contains("png")) {
    json["png"] = {
        {"transfer", "sRGB"}, {"tone", "clipped at 1"}, {"exposure", JsonNumber(exposure)}};
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace penumbra
