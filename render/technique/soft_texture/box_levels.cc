#include "render/technique/soft_texture/box_levels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/soft_texture/box_levels.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"
#include "render/technique/soft_texture/kernel_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

// Which of sixteen boxes reach inside every side, as bits. A box's corner furthest inside is
// n · middle + |n| · half.
HWY_INLINE uint32_t InsideAll(const BoxLevels::Level& level, size_t first,
                              const UnitBoxSides& sides) {
  const F f;
  uint32_t bits = 0;
  for (size_t k = 0; k < BoxLevels::kChildren; k += hn::Lanes(f)) {
    const size_t at = first + k;
    const auto load = [&](const std::vector<float>& values)
                          HWY_ATTR { return hn::LoadU(f, values.data() + at); };
    const VF x = load(level.x), y = load(level.y), z = load(level.z);
    const VF half_x = load(level.half_x), half_y = load(level.half_y), half_z = load(level.half_z);
    VF least = hn::Set(f, 1.0f);
    for (size_t s = 0; s < UnitBoxSides::kCount; ++s) {
      const VF nx = hn::Set(f, sides.x[s]), ny = hn::Set(f, sides.y[s]);
      const VF nz = hn::Set(f, sides.z[s]);
      const VF middle =
          hn::MulAdd(nx, x, hn::MulAdd(ny, y, hn::MulAdd(nz, z, hn::Set(f, sides.constant[s]))));
      const VF reach = hn::MulAdd(hn::Abs(nx), half_x,
                                  hn::MulAdd(hn::Abs(ny), half_y, hn::Mul(hn::Abs(nz), half_z)));
      least = hn::Min(least, hn::Add(middle, reach));
    }
    // Written so that what is not a number counts as inside.
    bits |= Bits(hn::Not(hn::Lt(least, hn::Zero(f)))) << k;
  }
  const size_t valid = level.count - first;
  return valid < BoxLevels::kChildren ? bits & ((1u << valid) - 1) : bits;
}

void SelectBoxes(std::span<const BoxLevels::Level> levels, const UnitBoxSides& sides,
                 std::vector<uint32_t>& found) {
  struct Pending {
    size_t level, first;
    uint32_t bits;  // of the sixteen boxes from `first` on, those to look into
  };
  Pending stack[16];  // 16^16 boxes
  const auto look = [&](size_t level, size_t first) HWY_ATTR {
    return Pending{level, first, InsideAll(levels[level], first, sides)};
  };
  stack[0] = look(levels.size() - 1, 0);
  for (size_t depth = 1; depth > 0;) {
    Pending& pending = stack[depth - 1];
    if (pending.level == 0) {
      for (; pending.bits != 0; pending.bits &= pending.bits - 1) {
        found.push_back(static_cast<uint32_t>(pending.first) +
                        static_cast<uint32_t>(__builtin_ctz(pending.bits)));
      }
    }
    if (pending.bits == 0) {
      --depth;
      continue;
    }
    const size_t box = pending.first + static_cast<size_t>(__builtin_ctz(pending.bits));
    pending.bits &= pending.bits - 1;
    stack[depth++] = look(pending.level - 1, box * BoxLevels::kChildren);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {
namespace {

BoxLevels::Level LevelOf(std::span<const Aabb> boxes) {
  BoxLevels::Level level{.count = boxes.size()};
  const size_t padded =
      (boxes.size() + BoxLevels::kChildren - 1) / BoxLevels::kChildren * BoxLevels::kChildren;
  for (auto* values : {&level.x, &level.y, &level.z, &level.half_x, &level.half_y, &level.half_z}) {
    values->resize(padded);
  }
  for (size_t b = 0; b < boxes.size(); ++b) {
    const Vec3 middle = boxes[b].center();
    // From the middle as it came out.
    const DVec3 half =
        glm::max(DVec3(boxes[b].max) - DVec3(middle), DVec3(middle) - DVec3(boxes[b].min));
    const DVec3 widened = half + kUnitBoxSlack * (half + glm::abs(DVec3(middle)));
    level.x[b] = middle.x;
    level.y[b] = middle.y;
    level.z[b] = middle.z;
    level.half_x[b] = static_cast<float>(widened.x);
    level.half_y[b] = static_cast<float>(widened.y);
    level.half_z[b] = static_cast<float>(widened.z);
  }
  return level;
}

}  // namespace

UnitBoxSides::UnitBoxSides(const ReceiverTransform& map, const TexelWindow& window,
                           uint32_t height) {
  const DVec3 rx = map.row_x(), ry = map.row_y(), rw = map.row_w();
  const double first = double{1.0} * window.row_begin / height;
  const double last = double{1.0} * window.row_end / height;
  const struct {
    DVec3 normal;
    double constant;
  } kSides[kCount] = {
      {rx, 0}, {rw - rx, 1}, {ry - first * rw, -first}, {last * rw - ry, last}, {rw, 1}};
  for (size_t s = 0; s < kCount; ++s) {
    x[s] = static_cast<float>(kSides[s].normal.x);
    y[s] = static_cast<float>(kSides[s].normal.y);
    z[s] = static_cast<float>(kSides[s].normal.z);
    constant[s] =
        static_cast<float>(kSides[s].constant + kUnitBoxSlack * std::abs(kSides[s].constant));
  }
}

bool MissesUnitBox(const Aabb& box, const UnitBoxSides& sides) {
  const DVec3 middle = 0.5 * (DVec3(box.min) + DVec3(box.max));
  const DVec3 half = 0.5 * (DVec3(box.max) - DVec3(box.min));
  const DVec3 widened = half + kUnitBoxSlack * (half + glm::abs(middle));
  for (size_t s = 0; s < UnitBoxSides::kCount; ++s) {
    const DVec3 normal(sides.x[s], sides.y[s], sides.z[s]);
    if (sides.constant[s] + glm::dot(normal, middle) + glm::dot(glm::abs(normal), widened) < 0) {
      return true;
    }
  }
  return false;
}

BoxLevels::BoxLevels(std::span<const Aabb> boxes) {
  std::vector<Aabb> parents(boxes.begin(), boxes.end());
  while (!parents.empty()) {
    levels_.push_back(LevelOf(parents));
    if (parents.size() <= kChildren) break;
    std::vector<Aabb> next((parents.size() + kChildren - 1) / kChildren);
    for (size_t b = 0; b < parents.size(); ++b) next[b / kChildren].Add(parents[b]);
    parents = std::move(next);
  }
}

HWY_EXPORT(SelectBoxes);

void BoxLevels::Select(const UnitBoxSides& sides, std::vector<uint32_t>& found) const {
  found.clear();
  if (!levels_.empty()) HWY_DYNAMIC_DISPATCH(SelectBoxes)(levels_, sides, found);
}

}  // namespace penumbra
#endif  // HWY_ONCE
