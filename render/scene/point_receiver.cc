#include "render/scene/point_receiver.h"

#include <string_view>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "render/scene/hashed_bytes.h"
#include "render/scene/scene.h"

namespace penumbra {
namespace {

absl::Status Invalid(std::string_view reason, std::string_view field, std::string_view text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

absl::Status CheckSides(std::string_view name, uint32_t width, uint32_t height,
                        const SceneLimits& limits) {
  for (const auto& [field, side] : {std::pair{"width", width}, {"height", height}}) {
    if (side >= 1 && side <= limits.max_receiver_side) continue;
    return Invalid("RANGE", std::string(name) + "." + field,
                   absl::StrCat("found ", side, ", need 1 to ", limits.max_receiver_side));
  }
  return absl::OkStatus();
}

absl::Status CheckTexels(std::string_view name, GridExtent grid, const SceneLimits& limits) {
  const uint64_t texels = uint64_t{grid.width} * grid.height;
  if (texels <= limits.max_receiver_texels) return absl::OkStatus();
  return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_TEXELS", name,
                    absl::StrCat("found ", grid.width, " by ", grid.height,
                                 " points, need at most ", limits.max_receiver_texels, " in all"));
}

std::string Text(const PixelRect& rect) {
  return absl::StrCat(rect.width, " by ", rect.height, " pixels from ", rect.x, ", ", rect.y);
}

bool IsInside(const PixelRect& inner, const PixelRect& outer) {
  return inner.x >= outer.x && inner.y >= outer.y &&
         uint64_t{inner.x} + inner.width <= uint64_t{outer.x} + outer.width &&
         uint64_t{inner.y} + inner.height <= uint64_t{outer.y} + outer.height;
}

// Whether `rect` is all 0, or not empty and inside.
absl::Status CheckRect(std::string_view field, const PixelRect& rect, const PixelRect& outer) {
  if (rect == PixelRect{} || (!rect.empty() && IsInside(rect, outer))) return absl::OkStatus();
  return Invalid("RANGE", field,
                 absl::StrCat("found ", Text(rect), ", need some of ", Text(outer)));
}

absl::Status CheckIt(const PicturePixels& picture, const SceneLimits& limits) {
  // The whole picture's sides say no more than how large pixels are: a deep zoom may be of a very
  // large one.
  constexpr uint32_t kMaxSide = 1u << 20;
  for (const auto& [field, side] :
       {std::pair{"picture.width", picture.width}, {"picture.height", picture.height}}) {
    if (side >= 1 && side <= kMaxSide) continue;
    return Invalid("RANGE", field, absl::StrCat("found ", side, ", need 1 to ", kMaxSide));
  }
  const absl::Status camera = CheckView({picture.camera, picture.aspect()}, limits);
  if (!camera.ok()) return WithFieldPrefix(camera, "picture.");
  const PixelRect whole{0, 0, picture.width, picture.height};
  if (auto status = CheckRect("picture.crop", picture.crop, whole); !status.ok()) return status;
  const PixelRect part = picture.part();
  if (auto status = CheckRect("picture.first", picture.first, part); !status.ok()) return status;
  const std::string_view name = picture.crop.empty() ? "picture" : "picture.crop";
  if (auto status = CheckSides(name, part.width, part.height, limits); !status.ok()) return status;
  return CheckTexels(name, {part.width, part.height}, limits);
}

absl::Status CheckIt(const LightmapTexels& lightmap, const SceneLimits& limits) {
  if (auto id = CheckId(lightmap.instance_id, "lightmap.instance_id"); !id.ok()) return id;
  const auto status = CheckSides("lightmap", lightmap.width, lightmap.height, limits);
  return status.ok() ? CheckTexels("lightmap", {lightmap.width, lightmap.height}, limits) : status;
}

absl::Status CheckIt(const GivenPoints& given, const SceneLimits& limits) {
  if (given.size() == 0) return Invalid("RANGE", "given", "found none, need at least one");
  if (given.size() > kMaxGivenPoints) {
    return FieldError(
        absl::StatusCode::kResourceExhausted, "QUOTA_POINTS", "given",
        absl::StrCat("found ", given.size(), ", need at most ", kMaxGivenPoints, " at a time"));
  }
  const float limit = limits.max_coordinate;
  for (size_t i = 0; i < given.size(); ++i) {
    const auto& [position, normal] = (*given.points)[i];
    const std::string field = absl::StrCat("given[", i, "]");
    if (!IsFinite(position)) {
      return Invalid("NON_FINITE", field + ".position", "need finite numbers");
    }
    if (!glm::all(glm::lessThanEqual(glm::abs(position), Vec3(limit)))) {
      return Invalid("OUT_OF_BOUNDS", field + ".position",
                     absl::StrCat("need coordinates of at most ", limit));
    }
    if (!IsFinite(normal) || normal == Vec3(0)) {
      return Invalid("RANGE", field + ".normal", "need finite numbers that are not all 0");
    }
  }
  return absl::OkStatus();
}

void Put(HashedBytes& out, const PixelRect& rect) {
  for (const uint32_t x : {rect.x, rect.y, rect.width, rect.height}) out.Put(x);
}

void Put(HashedBytes& out, const PicturePixels& picture) {
  for (const Vec3& v : {picture.camera.eye, picture.camera.target, picture.camera.up}) out.Put(v);
  out.Put(picture.camera.fov_y_deg);
  out.Put(picture.width);
  out.Put(picture.height);
  Put(out, picture.crop);
  Put(out, picture.first);
}

void Put(HashedBytes& out, const LightmapTexels& lightmap) {
  out.Put(lightmap.instance_id);
  out.Put(lightmap.width);
  out.Put(lightmap.height);
}

void Put(HashedBytes& out, const GivenPoints& given) {
  for (size_t i = 0; i < given.size(); ++i) {
    out.Put((*given.points)[i].position);
    out.Put((*given.points)[i].normal);
  }
}

}  // namespace

bool operator==(const GivenPoints& a, const GivenPoints& b) {
  if (a.points == b.points) return true;
  return a.size() == b.size() && (a.size() == 0 || *a.points == *b.points);
}

GridExtent GridOf(const PointReceiver& receiver) {
  struct Grid {
    GridExtent operator()(const PicturePixels& picture) const {
      const PixelRect part = picture.part();
      return {part.width, part.height};
    }
    GridExtent operator()(const LightmapTexels& lightmap) const {
      return {lightmap.width, lightmap.height};
    }
    GridExtent operator()(const GivenPoints& given) const {
      return {static_cast<uint32_t>(given.size()), 1};
    }
  };
  return std::visit(Grid{}, receiver);
}

absl::Status Check(const PointReceiver& receiver, const SceneLimits& limits) {
  return std::visit([&](const auto& one) { return CheckIt(one, limits); }, receiver);
}

ContentHash HashOf(const PointReceiver& receiver) {
  HashedBytes bytes;
  bytes.Put(static_cast<uint32_t>(receiver.index()));
  std::visit([&](const auto& one) { Put(bytes, one); }, receiver);
  return bytes.Hash();
}

}  // namespace penumbra
