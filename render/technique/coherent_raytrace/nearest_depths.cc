#include "render/technique/coherent_raytrace/nearest_depths.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

#include "render/math/parallel_for.h"
#include "render/technique/coherent_raytrace/shadow_tracer.h"

namespace penumbra {
namespace {

// What single precision may be off by: pixels, and shares of a nearness.
constexpr float kPixelSlack = 2e-3f;
constexpr float kNearnessSlack = 4e-6f;

// What is that much nearer to a light than all points is in nobody's way.
constexpr double kLightShare = 1.0 - kRayEnd;

// Pixels to either side beyond which single precision is not enough.
constexpr float kReach = 16384.0f;

struct Corner {
  float x, y, nearness;
};

// Depths that grow as triangles are drawn, in any order, by any number of threads.
class Picture {
 public:
  Picture(int width, int height, std::vector<float>& nearest)
      : width_(width), height_(height), nearest_(nearest) {}

  void Draw(const std::array<Corner, 3>& t);
  // All pixels that the box touches.
  void DrawBox(Vec2 min, Vec2 max, float nearness);
  bool Contains(Vec2 min, Vec2 max) const {
    return min.x >= 0 && min.y >= 0 && max.x < width_ && max.y < height_;
  }
  // As many threads at a time as like may raise one.
  static void Raise(float& known, float nearness);

 private:
  // plane  nearness at the first corner, and by how much it grows along x and y
  void DrawRow(const std::array<Corner, 3>& t, int row, Corner plane, float most);
  void Raise(int x, int y, float nearness) {
    Raise(nearest_[static_cast<size_t>(y) * width_ + x], nearness);
  }

  const int width_, height_;
  std::vector<float>& nearest_;
};

void Picture::Raise(float& known, float nearness) {
  const std::atomic_ref<float> shared(known);
  float now = shared.load(std::memory_order_relaxed);
  while (now < nearness &&
         !shared.compare_exchange_weak(now, nearness, std::memory_order_relaxed)) {
  }
}

void Picture::DrawBox(Vec2 min, Vec2 max, float nearness) {
  const auto first = [](float v) { return std::max(0, static_cast<int>(std::floor(v))); };
  const auto last = [](float v, int size) {
    return std::min(size - 1, static_cast<int>(std::floor(v)));
  };
  if (!(max.x >= 0 && max.y >= 0 && min.x < width_ && min.y < height_)) return;
  const int x1 = last(std::min(max.x, kReach), width_), y1 = last(std::min(max.y, kReach), height_);
  for (int y = first(min.y); y <= y1; ++y) {
    for (int x = first(min.x); x <= x1; ++x) Raise(x, y, nearness);
  }
}

void Picture::Draw(const std::array<Corner, 3>& t) {
  Vec2 min(std::min({t[0].x, t[1].x, t[2].x}), std::min({t[0].y, t[1].y, t[2].y}));
  Vec2 max(std::max({t[0].x, t[1].x, t[2].x}), std::max({t[0].y, t[1].y, t[2].y}));
  min -= kPixelSlack, max += kPixelSlack;
  const float most = (1 + kNearnessSlack) * std::max({t[0].nearness, t[1].nearness, t[2].nearness});
  const bool is_small = max.x - min.x < 2 && max.y - min.y < 2;
  const bool is_far_out = !(min.x > -kReach && min.y > -kReach && max.x < kReach && max.y < kReach);
  if (is_small || is_far_out) return DrawBox(min, max, most);
  const float ax = t[1].x - t[0].x, ay = t[1].y - t[0].y, an = t[1].nearness - t[0].nearness;
  const float bx = t[2].x - t[0].x, by = t[2].y - t[0].y, bn = t[2].nearness - t[0].nearness;
  const float area2 = ax * by - ay * bx;
  // A sliver's plane is not known well; its nearest corner is.
  const float longest2 = std::max(ax * ax + ay * ay, bx * bx + by * by);
  const bool is_sliver = std::abs(area2) < 1e-2f * std::sqrt(longest2);
  const Corner plane =
      is_sliver ? Corner{0.0f, 0.0f, most}
                : Corner{(an * by - bn * ay) / area2, (ax * bn - bx * an) / area2, t[0].nearness};
  const int last = std::min(height_ - 1, static_cast<int>(std::floor(max.y)));
  for (int row = std::max(0, static_cast<int>(std::floor(min.y))); row <= last; ++row) {
    DrawRow(t, row, plane, most);
  }
}

void Picture::DrawRow(const std::array<Corner, 3>& t, int row, Corner plane, float most) {
  const float low = row - kPixelSlack, high = row + 1 + kPixelSlack;
  float from = kReach, to = -kReach;  // what of the row the triangle touches
  for (int i = 0; i < 3; ++i) {
    const Corner &a = t[i], &b = t[(i + 1) % 3];
    if (std::max(a.y, b.y) < low || std::min(a.y, b.y) > high) continue;
    const float run = b.y == a.y ? 0.0f : (b.x - a.x) / (b.y - a.y);
    for (const float y : {std::clamp(a.y, low, high), std::clamp(b.y, low, high)}) {
      const float x = y == a.y ? a.x : y == b.y ? b.x : a.x + (y - a.y) * run;
      from = std::min(from, x), to = std::max(to, x);
    }
  }
  const int first = std::max(0, static_cast<int>(std::floor(from - kPixelSlack)));
  const int last = std::min(width_ - 1, static_cast<int>(std::floor(to + kPixelSlack)));
  const float reach = 0.5f * (std::abs(plane.x) + std::abs(plane.y));
  const float middle = plane.nearness + plane.y * (row + 0.5f - t[0].y) + reach;
  for (int x = first; x <= last; ++x) {
    const float nearest = middle + plane.x * (x + 0.5f - t[0].x);
    Raise(x, row, std::min(most, nearest + kNearnessSlack * std::abs(nearest)));
  }
}

// All ways from a light to points that its picture shows: at depth z between the slopes of the
// picture's edges times z, and the light's own width further.
struct Beam {
  Window slopes;  // with 0 in it
  Window light;   // so too
  double near;

  // How deep what of a triangle is in the beam begins; infinity where none is.
  double NearestOf(const std::array<DVec3, 3>& triangle) const;

 private:
  // How far inside p is of one of the beam's five sides.
  double Inside(int side, DVec3 p) const {
    if (side == 4) return p.z - near;
    const int axis = side / 2;
    return side % 2 == 0 ? p[axis] - (light.min[axis] + p.z * slopes.min[axis])
                         : light.max[axis] + p.z * slopes.max[axis] - p[axis];
  }
};

double Beam::NearestOf(const std::array<DVec3, 3>& triangle) const {
  std::array<DVec3, 8> polygon, old;  // each side adds a corner at most
  size_t count = triangle.size();
  std::ranges::copy(triangle, polygon.begin());
  for (int side = 0; side < 5; ++side) {
    old = polygon;
    const size_t corners = std::exchange(count, 0);
    for (size_t i = 0; i < corners; ++i) {
      const DVec3 &a = old[i], &b = old[(i + 1) % corners];
      const double in_a = Inside(side, a), in_b = Inside(side, b);
      if (in_a >= 0 && count < polygon.size()) polygon[count++] = a;
      if ((in_a >= 0) != (in_b >= 0) && count < polygon.size()) {
        polygon[count++] = glm::mix(a, b, in_a / (in_a - in_b));
      }
    }
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < count; ++i) nearest = std::min(nearest, polygon[i].z);
  return nearest;
}

// Draws what of a triangle is in front of the eye.
class TriangleDrawer {
 public:
  TriangleDrawer(const LightView& view, const Window& light, Picture& picture, float& beside)
      : view_(view),
        nearness_(view),
        scale_(view.pixels_per_slope()),
        beam_{.slopes = WithZero(view.window),
              .light = WithZero(light),
              .near = kLightShare * view.near},
        picture_(picture),
        beside_(beside) {}

  void Draw(const std::array<DVec3, 3>& q) {
    const int behind = (q[0].z < beam_.near) + (q[1].z < beam_.near) + (q[2].z < beam_.near);
    if (view_.from_infinity || behind == 0) {
      const std::array<Corner, 3> corners{Project(q[0]), Project(q[1]), Project(q[2])};
      picture_.Draw(corners);
      NoteBeside(q, glm::min(At(corners[0]), glm::min(At(corners[1]), At(corners[2]))),
                 glm::max(At(corners[0]), glm::max(At(corners[1]), At(corners[2]))));
    } else if (behind < 3) {
      DrawCut(q);
    }
  }

 private:
  static Window WithZero(const Window& window) {
    return {.min = glm::min(window.min, DVec2(0.0)), .max = glm::max(window.max, DVec2(0.0))};
  }
  static Vec2 At(const Corner& corner) { return Vec2(corner.x, corner.y); }

  void NoteBeside(const std::array<DVec3, 3>& q, Vec2 min, Vec2 max) {
    if (view_.from_infinity || picture_.Contains(min - kPixelSlack, max + kPixelSlack)) return;
    const double nearest = beam_.NearestOf(q);
    if (std::isfinite(nearest)) {
      Picture::Raise(beside_, (1 + kNearnessSlack) * static_cast<float>(nearness_.Of(nearest)));
    }
  }

  Corner Project(DVec3 q) const {
    const DVec2 at = view_.from_infinity ? DVec2(q) + q.z * DVec2(view_.eye) : DVec2(q) / q.z;
    const DVec2 pixel = (at - view_.window.min) * scale_;
    return {static_cast<float>(pixel.x), static_cast<float>(pixel.y),
            static_cast<float>(nearness_.Of(q.z))};
  }

  // As near as the near plane wherever it is.
  void DrawCut(const std::array<DVec3, 3>& q) {
    const double near = beam_.near;
    Vec2 min(kReach), max(-kReach);
    const auto add = [&](DVec3 p) {
      const Vec2 at = At(Project(p));
      min = glm::min(min, at);
      max = glm::max(max, at);
    };
    for (int i = 0; i < 3; ++i) {
      const DVec3 &a = q[i], &b = q[(i + 1) % 3];
      if (a.z >= near) add(a);
      if ((a.z >= near) == (b.z >= near)) continue;
      DVec3 p = glm::mix(a, b, (near - a.z) / (b.z - a.z));
      p.z = near;
      add(p);
    }
    picture_.DrawBox(min - kPixelSlack, max + kPixelSlack, static_cast<float>(nearness_.Of(near)));
    NoteBeside(q, min, max);
  }

  const LightView& view_;
  const Nearness nearness_;
  const DVec2 scale_;
  const Beam beam_;
  Picture& picture_;
  float& beside_;
};

}  // namespace

NearestDepths::NearestDepths(const LightView& view, const Scene& scene, const Window& light,
                             tbb::task_arena& arena, const std::stop_token& stop)
    : view_(view) {
  const int width = static_cast<int>(view.width), height = static_cast<int>(view.height);
  levels_.push_back({width, height, std::vector<float>(size_t{view.width} * view.height)});
  Picture picture(width, height, levels_[0].nearest);
  for (const auto& entry : scene.instances()) {
    const Instance& instance = *entry.second;
    if (!instance.casts || stop.stop_requested()) continue;
    std::vector<DVec3> placed(instance.mesh->vertex_count());
    const DVec3 eye = view.from_infinity ? DVec3(0.0) : view.eye;
    RunIn(arena, [&] {
      ParallelFor(placed.size(), [&](size_t i) {
        const Vec3 p = TransformPoint(instance.world_from_mesh, instance.mesh->positions()[i]);
        placed[i] = view.frame.FromWorld(DVec3(p)) - eye;
      });
      ParallelFor(instance.mesh->triangle_count(), [&](size_t i) {
        if (stop.stop_requested()) return;
        const uint32_t* const corners = &instance.mesh->indices()[3 * i];
        TriangleDrawer(view, light, picture, beside_)
            .Draw({placed[corners[0]], placed[corners[1]], placed[corners[2]]});
      });
    });
  }
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
    coarse.nearest.resize(static_cast<size_t>(coarse.width) * coarse.height);
    for (int y = 0; y < fine.height; ++y) {
      const float* const row = &fine.nearest[static_cast<size_t>(y) * fine.width];
      float* const out = &coarse.nearest[static_cast<size_t>(y / 2) * coarse.width];
      for (int x = 0; x < fine.width; ++x) out[x / 2] = std::max(out[x / 2], row[x]);
    }
    levels_.push_back(std::move(coarse));
  }
}

float NearestDepths::At(int x, int y) const {
  const Level& pixels = levels_[0];
  if (x < 0 || y < 0 || x >= pixels.width || y >= pixels.height) return 0.0f;
  return pixels.nearest[static_cast<size_t>(y) * pixels.width + x];
}

float NearestDepths::In(Vec2 min, Vec2 max) const {
  const Level& pixels = levels_[0];
  if (!(max.x >= 0 && max.y >= 0 && min.x < pixels.width && min.y < pixels.height)) return 0.0f;
  int x0 = static_cast<int>(std::max(0.0f, min.x)), y0 = static_cast<int>(std::max(0.0f, min.y));
  int x1 = static_cast<int>(std::min(max.x, pixels.width - 1.0f));
  int y1 = static_cast<int>(std::min(max.y, pixels.height - 1.0f));
  size_t level = 0;
  for (; x1 - x0 > 2 || y1 - y0 > 2; ++level) x0 /= 2, y0 /= 2, x1 /= 2, y1 /= 2;
  const Level& l = levels_[level];
  float nearest = 0.0f;
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      nearest = std::max(nearest, l.nearest[static_cast<size_t>(y) * l.width + x]);
    }
  }
  return nearest;
}

}  // namespace penumbra
