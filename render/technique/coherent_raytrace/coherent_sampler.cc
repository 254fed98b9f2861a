#include "render/technique/coherent_raytrace/coherent_sampler.h"

#include <algorithm>

#include "render/math/random.h"

namespace penumbra {
void PointSamples::Place(const CellGrid& grid, uint64_t seed, uint64_t point_index) {
  PlaceSamples(grid, MixBits(MixBits(seed) ^ point_index), {u.data(), v.data(), part.data()});
}

void CoherentSampler::Blockers::Add(Vec3 p) {
  if (x.size() < count + 1 + kSamplerLanes) {
    for (auto* axis : {&x, &y, &z}) axis->resize(2 * count + 16 * kSamplerLanes);
  }
  x[count] = p.x, y[count] = p.y, z[count] = p.z;
  ++count;
}

CoherentSampler::CoherentSampler(const LightSquare& square, const ShadowTracer& tracer,
                                 const SamplingSettings& settings)
    : square_(square),
      tracer_(tracer),
      settings_(settings),
      grid_{settings.side, settings.parts},
      seen_(square.From(Vec3(0.0f))) {
  if (square.is_single()) settings_.predicts = false;  // its ray is all there is to know
  const uint32_t along = settings.side * settings.parts;
  taken_.resize(size_t{along} * along);
  Restart();
  for (uint32_t part = 0; part < along * along; ++part) {
    const uint32_t x = part % along / settings.parts, y = part / along / settings.parts;
    cell_of_part_.push_back(static_cast<uint16_t>(CellMask::kMaxSide * y + x));
  }
}

void CoherentSampler::Restart() {
  has_previous_ = false;
  turn_ = 0;
  blockers_.count = 0;
}

bool CoherentSampler::IsNear(const SurfacePoint& point) const {
  const Vec3 way = point.position - previous_;
  return has_previous_ &&
         glm::dot(way, way) <= settings_.prediction_distance * settings_.prediction_distance;
}

CoherentSampler::Prediction CoherentSampler::Predict() {
  Prediction prediction{CellMask(settings_.side), CellMask(settings_.side)};
  std::ranges::fill(taken_, 0);
  Blockers& b = blockers_;
  part_.resize(b.count + kSamplerLanes);
  seen_.PartsBehind(grid_, b.x.data(), b.y.data(), b.z.data(), b.count, part_.data());
  // Without branches: which blockers are kept is as good as random.
  size_t kept = 0;
  for (size_t i = 0; i < b.count; ++i) {
    const bool is_on_light = part_[i] >= 0;
    const int32_t part = is_on_light ? part_[i] : 0;
    const uint32_t cell = cell_of_part_[part];
    uint8_t& taken = taken_[part];
    const bool is_kept = is_on_light & !taken;
    taken |= is_on_light;
    prediction.blocked.AddIf(is_on_light, cell);
    prediction.done.AddIf(is_on_light & (samples_.part[cell] == part), cell);
    b.x[kept] = b.x[i], b.y[kept] = b.y[i], b.z[kept] = b.z[i];
    kept += is_kept;
  }
  b.count = kept;
  if (!settings_.skips_known_rays) prediction.done = CellMask(settings_.side);
  return prediction;
}

CellMask CoherentSampler::Below(const Vec3& normal) const {
  const uint32_t side = settings_.side;
  switch (seen_.SideOf(normal)) {
    case LightSquare::Seen::Side::kAbove:
      return CellMask(side);
    case LightSquare::Seen::Side::kBelow:
      return CellMask::All(side);
    case LightSquare::Seen::Side::kBoth:
      break;
  }
  CellMask below(side);
  CellMask::All(side).ForEach([&](uint32_t cell) {
    if (!seen_.IsAbove(seen_.TargetAt(samples_.At(cell)), normal)) below.Add(cell);
  });
  return below;
}

CellMask CoherentSampler::Trace(const SurfacePoint& point, const CellMask& cells) {
  size_t n = 0;
  cells.ForEach([&](uint32_t cell) {
    const Vec3 target = seen_.TargetAt(samples_.At(cell));
    cells_[n] = cell;
    x_[n] = target.x, y_[n] = target.y, z_[n] = target.z;
    ++n;
  });
  const bool at_infinity = square_.is_at_infinity();
  tracer_.Trace({.from = point,
                 .at_infinity = at_infinity,
                 .wants_blockers = settings_.predicts,
                 .x = {x_.data(), n},
                 .y = {y_.data(), n},
                 .z = {z_.data(), n}},
                {blocked_at_.data(), n}, counts_);
  CellMask blocked(settings_.side);
  for (size_t i = 0; i < n; ++i) {
    if (blocked_at_[i] == kUnblocked) continue;
    blocked.Add(cells_[i]);
    if (!settings_.predicts) continue;
    const Vec3 target(x_[i], y_[i], z_[i]);
    const Vec3 way = at_infinity ? target : target - point.position;
    blockers_.Add(point.position + blocked_at_[i] * way);
  }
  return blocked;
}

CellMask CoherentSampler::Visible(const SurfacePoint& point, uint64_t point_index,
                                  const KnownCells& known) {
  const uint32_t side = settings_.side;
  const CellMask all = CellMask::All(side);
  if (square_.IsDarkAt(point.position)) {
    has_previous_ = false;
    return CellMask(side);
  }
  if (known.lit == all) {
    // No blocker hides any of it: they are forgotten as if each had been projected.
    blockers_.count = 0;
    previous_ = point.position, has_previous_ = true;
    unknown_ = CellMask(side);
    return all;
  }
  seen_ = square_.From(point.position);
  samples_.Place(grid_, settings_.seed, point_index);
  const CellMask below = Below(point.normal);
  const bool uses_prediction = settings_.predicts && IsNear(point);
  Prediction prediction{CellMask(side), CellMask(side)};
  if (uses_prediction) {
    prediction = Predict();
  } else {
    blockers_.count = 0;
  }
  return Complete(point, uses_prediction, prediction, known, below);
}

CellMask CoherentSampler::Complete(const SurfacePoint& point, bool uses_prediction,
                                   const Prediction& prediction, const KnownCells& known,
                                   const CellMask& below) {
  const uint32_t side = settings_.side;
  const CellMask all = CellMask::All(side);
  CellMask blocked = (prediction.blocked - known.lit) | known.dark;
  const CellMask done = known.lit | known.dark | below | prediction.done;
  CellMask todo = all - done;
  if (uses_prediction) {
    CellMask exterior = CellMask::Exterior(side);
    if (settings_.alternates_exterior) exterior &= CellMask::Checkered(side, ++turn_ % 2);
    todo &= blocked.Boundary() | exterior | unknown_;
  }
  CellMask uses_previous = all - done - todo;
  while (!todo.empty()) {
    const CellMask hit = Trace(point, todo);
    const CellMask wrong = (hit - blocked) | ((blocked & todo) - hit);
    blocked = (blocked - todo) | hit;
    todo = wrong.Dilated() & uses_previous;
    uses_previous -= todo;
  }
  previous_ = point.position, has_previous_ = true;
  unknown_ = below | known.dark;
  return all - blocked - below;
}

}  // namespace penumbra
