#include "render/technique/coherent_raytrace/light_proof.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "render/technique/coherent_raytrace/light_eye.h"

namespace penumbra {
namespace {

// A window that shrinks by less in a step will not get much smaller.
constexpr double kLeastShrinking = 0.85;
constexpr int kMaxSteps = 16;

// Pixels along a side of the largest window of which each is held against the point's own plane.
constexpr double kMaxPlaneWindow = 5.0;

// Over a pixel of a steeper surface something may stand as high as the surface rises within it.
constexpr double kMaxSteepness = 1.0;

// The point's surface as a picture shows it: nearness over the image is a plane.
struct Footing {
  DVec2 pixel;
  double nearness;
  DVec2 slope;       // of nearness, per pixel
  double bias;       // in nearness
  double steepness;  // how many pixels' widths deeper the surface gets within a pixel

  double PlaneOver(int x, int y) const {
    const DVec2 off = DVec2(x + 0.5, y + 0.5) - pixel;
    return nearness + glm::dot(slope, off) + 0.5 * (std::abs(slope.x) + std::abs(slope.y));
  }
};

std::optional<Footing> FootingIn(const LightView& view, const SurfacePoint& point, double bias) {
  const DVec3 q = view.frame.FromWorld(DVec3(point.position));
  const DVec3 n = view.frame.DirectionFromWorld(DVec3(point.normal));
  const DVec3 from_eye = view.from_infinity ? q : q - view.eye;
  if (!view.from_infinity && !(from_eye.z > view.near * (1 - 0x1p-20))) return std::nullopt;
  const DVec3 at = view.ProjectInFrame(q);
  if (!(at.x >= 0 && at.y >= 0 && at.x < view.width && at.y < view.height)) return std::nullopt;
  // The eye is over the surface.
  const double facing =
      view.from_infinity ? n.z - glm::dot(DVec2(n), DVec2(view.eye)) : glm::dot(n, from_eye);
  if (!(facing < 0)) return std::nullopt;
  const DVec2 pixels = view.pixels_per_slope();
  const double nearness = Nearness(view).Of(at.z);
  const DVec2 slope = DVec2(n) / facing / pixels;
  // In nearness, as deep as a pixel is wide.
  const double width = (view.from_infinity ? 1.0 : nearness) / std::min(pixels.x, pixels.y);
  return Footing{.pixel = DVec2(at),
                 .nearness = nearness,
                 .slope = slope,
                 .bias = bias * width,
                 .steepness = (std::abs(slope.x) + std::abs(slope.y)) / width};
}

// Whether every pixel of the window shows the point's own surface, or what is further.
bool IsOwnSurface(const NearestDepths& nearest, DVec2 min, DVec2 max, const Footing& footing) {
  if (footing.steepness > kMaxSteepness) return false;
  if (max.x - min.x > kMaxPlaneWindow || max.y - min.y > kMaxPlaneWindow) return false;
  for (int y = static_cast<int>(std::floor(min.y)); y <= std::floor(max.y); ++y) {
    for (int x = static_cast<int>(std::floor(min.x)); x <= std::floor(max.x); ++x) {
      if (nearest.At(x, y) > footing.PlaneOver(x, y) + footing.bias) return false;
    }
  }
  return true;
}

// How far the window of a part of the light, given by its square's corners, spans per nearness.
// nullopt where the light is not in one plane with the eye, along the image.
std::optional<LightPart> PartIn(const LightView& view, const LightSquare& square, Vec2 min,
                                Vec2 max) {
  constexpr uint32_t kPoints = 8;  // along each side
  const LightSquare::Seen seen = square.From(Vec3(0.0f));
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  LightPart part{DVec2(kInfinity), DVec2(-kInfinity)};
  for (uint32_t i = 0; i < (kPoints + 1) * (kPoints + 1); ++i) {
    const Vec2 at = Vec2(i % (kPoints + 1), i / (kPoints + 1)) / static_cast<float>(kPoints);
    const DVec3 target(seen.TargetAt(glm::mix(min, max, at)));
    DVec2 off;
    if (view.from_infinity) {
      const DVec3 d = view.frame.DirectionFromWorld(target);
      off = DVec2(d) / -d.z - DVec2(view.eye);
    } else {
      const DVec3 q = view.frame.FromWorld(target) - view.eye;
      if (std::abs(q.z) > 1e-5 * glm::length(q) + 1e-7 * view.far) return std::nullopt;
      off = DVec2(q);
    }
    part.low = glm::min(part.low, off);
    part.high = glm::max(part.high, off);
  }
  if (square.kind() != LightSquare::Kind::kRectangle) {
    // Between the points on an arc, which turn by less than 0.2, it bulges by up to 1/200.
    const DVec2 bulge = 0.01 * (part.high - part.low);
    part.low -= bulge;
    part.high += bulge;
  }
  const DVec2 pixels = view.pixels_per_slope();
  return LightPart{part.low * pixels, part.high * pixels};
}

}  // namespace

std::optional<LightProof::Parts> LightProof::PartsIn(const LightView& view) const {
  Parts parts;
  for (int level = 0; level < kLevels; ++level) {
    const uint32_t count = 1u << level;
    for (uint32_t i = 0; i < count * count; ++i) {
      const Vec2 corner(i % count, i / count);
      const float side = 1.0f / static_cast<float>(count);
      const auto part = PartIn(view, square_, side * corner, side * (corner + 1.0f));
      if (!part) return std::nullopt;
      parts[level].push_back(*part);
    }
  }
  return parts;
}

LightProof::LightProof(const AreaLight& light, const Scene& scene, const ProofSettings& settings,
                       tbb::task_arena& arena, const std::stop_token& stop)
    : square_(light), bias_(settings.bias) {
  if (square_.is_single()) return;  // its one ray costs less
  const Vec3 middle = square_.From(scene.Bounds().center()).TargetAt(Vec2(0.5f));
  AddEye(light, scene, middle, settings.pixels, arena, stop);
  if (!settings.has_quarters || square_.kind() == LightSquare::Kind::kSphere) return;
  for (const Vec2 at :
       {Vec2(0.25f, 0.25f), Vec2(0.75f, 0.25f), Vec2(0.25f, 0.75f), Vec2(0.75f, 0.75f)}) {
    AddEye(light, scene, square_.From(Vec3(0.0f)).TargetAt(at), settings.pixels, arena, stop);
  }
}

void LightProof::AddEye(const AreaLight& light, const Scene& scene, Vec3 place, uint32_t pixels,
                        tbb::task_arena& arena, const std::stop_token& stop) {
  Eye eye;
  for (const auto& [view, covers_all] : ViewsFrom(light, scene, place, pixels)) {
    if (auto parts = PartsIn(view)) {
      const DVec2 scale = view.pixels_per_slope();
      const LightPart& all = (*parts)[0][0];
      const Window around{.min = all.low / scale, .max = all.high / scale};
      eye.push_back(
          {NearestDepths(view, scene, around, arena, stop), covers_all, *std::move(parts)});
    }
  }
  eyes_.push_back(std::move(eye));
}

class LightProof::Stand {
 public:
  struct InEye {
    const Picture* picture = nullptr;  // null: none in which the point's surface is seen at all
    Footing footing;
  };

  Stand(const LightProof& proof, const SurfacePoint& point) : proof_(proof), point_(point) {}

  const InEye& In(size_t eye) {
    InEye& in_eye = in_eyes_[eye];
    if (!is_known_[eye]) {
      is_known_[eye] = true;
      for (const Picture& picture : proof_.eyes_[eye]) {
        const auto footing = FootingIn(picture.nearest.view(), point_, proof_.bias_);
        if (!footing) continue;
        const DVec2 at = footing->pixel;
        if (IsOwnSurface(picture.nearest, at, at, *footing)) in_eye = {&picture, *footing};
        break;
      }
    }
    return in_eye;
  }

 private:
  const LightProof& proof_;
  const SurfacePoint& point_;
  std::array<bool, kEyes> is_known_{};
  std::array<InEye, kEyes> in_eyes_;
};

size_t LightProof::EyeIn(int level, uint32_t x, uint32_t y) const {
  if (level == 0 || eyes_.size() == 1) return 0;
  return 1 + (y >> (level - 1)) * 2 + (x >> (level - 1));
}

bool LightProof::IsLit(int level, uint32_t x, uint32_t y, Stand& stand) const {
  const auto& [picture, footing] = stand.In(EyeIn(level, x, y));
  if (!picture) return false;
  const NearestDepths& nearest = picture->nearest;
  const LightPart& part = picture->parts[level][(y << level) + x];
  const DVec2 low = glm::min(part.low, DVec2(0.0)), high = glm::max(part.high, DVec2(0.0));
  double above = nearest.All() - footing.nearness;  // what is nearer is not in the hull
  for (int step = 0; step < kMaxSteps; ++step) {
    const DVec2 min = footing.pixel + above * low, max = footing.pixel + above * high;
    const DVec2 size(nearest.view().width, nearest.view().height);
    if (!picture->covers_all && !(min.x >= 0 && min.y >= 0 && max.x < size.x && max.y < size.y)) {
      return false;
    }
    const double found = nearest.In(Vec2(min), Vec2(max)) - footing.nearness;
    if (found <= footing.bias) return true;
    if (found > kLeastShrinking * above) return IsOwnSurface(nearest, min, max, footing);
    above = found;
  }
  return false;
}

void LightProof::Refine(int level, uint32_t x, uint32_t y, Stand& stand, CellMask& lit) const {
  const uint32_t side = lit.side(), cells = side >> level;
  if (IsLit(level, x, y, stand)) {
    lit |= CellMask::Block(side, x * cells, y * cells, (x + 1) * cells, (y + 1) * cells);
    return;
  }
  if (level + 1 == kLevels || cells % 2 != 0 || square_.kind() == LightSquare::Kind::kSphere) {
    return;
  }
  if (eyes_.size() == 1 && !stand.In(0).picture) return;
  for (uint32_t i = 0; i < 4; ++i) Refine(level + 1, 2 * x + i % 2, 2 * y + i / 2, stand, lit);
}

CellMask LightProof::LitFrom(const SurfacePoint& point, uint32_t side) const {
  CellMask lit(side);
  if (eyes_.empty() || square_.IsDarkAt(point.position)) return lit;
  if (square_.From(point.position).SideOf(point.normal) == LightSquare::Seen::Side::kAbove) {
    Stand stand(*this, point);
    Refine(0, 0, 0, stand, lit);
  }
  return lit;
}

}  // namespace penumbra
