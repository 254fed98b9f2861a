#include "render/technique/shadow_volume/wall_fit.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>

#include "render/technique/shadow_volume/wall_edges.h"

namespace penumbra {
namespace {

// Steeper surfaces are seen too much from their edge for their slope to be told.
constexpr double kMaxWallSlope = 128.0;

// How far below a near surface walls begin, as a part of what it changes by from sample to sample.
constexpr double kNearSink = 0.5;

double Cross(DVec2 a, DVec2 b) { return a.x * b.y - a.y * b.x; }
DVec2 PlaceOf(GridCorner corner) { return DVec2(corner.x, corner.y); }

// Nearness of a surface at a contour, and how far below and above a wall's may be.
struct Height {
  double value;             // half the way between the samples
  double tolerance = 0;     // of what a wall has
  double towards_left = 0;  // what the value changes by from the right sample to the left
};

// What a contour says at one place on its way.
struct Stop {
  DVec2 left_end, right_end;  // that it passes between; one place: that it passes through
  Height left, right;
  DVec2 to_left{0.0};
};

WallPost PostIn(const Stop& stop) {
  return {.at = 0.5 * (stop.left_end + stop.right_end),
          .left = stop.left.value,
          .right = stop.right.value,
          .to_left = stop.to_left};
}

// The surface's nearness where a way passes the stop `off` samples to the left of its middle.
double HeightThere(const Height& height, double off) {
  return std::isinf(height.value) ? height.value : height.value + off * height.towards_left;
}

// The ways from a post through stop after stop.
class Funnel {
 public:
  explicit Funnel(const WallPost& from) : from_(from) {}

  // False: none goes through this stop as well.
  bool Pass(const Stop& stop) {
    const DVec2 left = stop.left_end - from_.at, right = stop.right_end - from_.at;
    const DVec2 ahead = 0.5 * (left + right);
    if (glm::dot(ahead, ahead) < 1e-18) return false;
    if (!has_wedge_) {
      if (Cross(right, left) < 0) return false;  // a half turn or more
      left_way_ = left, right_way_ = right;
      has_wedge_ = true;
      return true;
    }
    if (glm::dot(ahead, left_way_ + right_way_) <= 0) return false;
    if (Cross(left, left_way_) > 0) left_way_ = left;
    if (Cross(right_way_, right) > 0) right_way_ = right;
    return Cross(right_way_, left_way_) >= 0;
  }

  // On the last stop that was passed: in the middle of where ways go through.
  WallPost PostAt(const Stop& stop) const {
    const double first = Meet(right_way_, stop, 0.0), last = Meet(left_way_, stop, 1.0);
    const DVec2 at = glm::mix(stop.right_end, stop.left_end, 0.5 * (first + last));
    const double off = glm::dot(at - 0.5 * (stop.left_end + stop.right_end), stop.to_left);
    return {.at = at,
            .left = HeightThere(stop.left, off),
            .right = HeightThere(stop.right, off),
            .to_left = stop.to_left};
  }

 private:
  // Where along the stop, 0 at its right end and 1 at its left, the way from the post meets it.
  double Meet(DVec2 way, const Stop& stop, double otherwise) const {
    const DVec2 along = stop.left_end - stop.right_end;
    const double across = Cross(way, along);
    if (across == 0) return otherwise;
    return std::clamp(Cross(stop.right_end - from_.at, way) / across, 0.0, 1.0);
  }

  WallPost from_;
  bool has_wedge_ = false;
  DVec2 left_way_{0.0}, right_way_{0.0};
};

bool IsWithin(double found, const Height& height, double off) {
  return std::isinf(height.value) || std::abs(found - HeightThere(height, off)) <= height.tolerance;
}

// Whether the wall between two posts is as high as the surfaces at the stops between them.
bool Fits(const WallPost& from, const WallPost& to, std::span<const Stop> between) {
  const DVec2 way = to.at - from.at;
  for (const Stop& stop : between) {
    const DVec2 along = stop.left_end - stop.right_end, start = stop.right_end - from.at;
    const double across = Cross(way, along);
    if (across == 0) continue;
    const double t = Cross(start, along) / across;  // of the way
    const double off =
        glm::dot(t * way + from.at - 0.5 * (stop.left_end + stop.right_end), stop.to_left);
    if (!IsWithin(std::lerp(from.left, to.left, t), stop.left, off)) return false;
    if (!IsWithin(std::lerp(from.right, to.right, t), stop.right, off)) return false;
  }
  return true;
}

class Fitter {
 public:
  Fitter(const VolumeGrid& grid, const EdgeMap& edges) : grid_(grid), edges_(edges) {}

  std::vector<WallPost> Fit(const Contour& contour) const {
    std::vector<Stop> stops;
    if (contour.first_cell) stops.push_back(StopIn(*contour.first_cell, contour.gates.front()));
    const bool first_fixed = !contour.first_cell && !contour.is_closed;
    const bool last_fixed = !contour.last_cell && !contour.is_closed;
    for (size_t i = 0; i < contour.gates.size(); ++i) {
      const bool is_end = i + 1 == contour.gates.size();
      const bool is_fixed = (i == 0 && first_fixed) || (is_end && last_fixed);
      stops.push_back(is_fixed ? BorderStop(contour.gates[i]) : StopAt(contour.gates[i]));
    }
    if (contour.last_cell) stops.push_back(StopIn(*contour.last_cell, contour.gates.back()));
    if (contour.is_closed) {
      const DVec2 middle = 0.5 * (stops[0].left_end + stops[0].right_end);
      stops[0].left_end = stops[0].right_end = middle;
      stops.push_back(stops[0]);
    }
    return Run(stops);
  }

 private:
  static std::vector<WallPost> Run(const std::vector<Stop>& stops) {
    std::vector<WallPost> posts = {PostIn(stops[0])};
    size_t next = 1;
    while (next < stops.size()) {
      Funnel funnel(posts.back());
      std::vector<WallPost> reached;  // at stops next, next + 1, …
      while (next + reached.size() < stops.size() && funnel.Pass(stops[next + reached.size()])) {
        reached.push_back(funnel.PostAt(stops[next + reached.size()]));
      }
      const size_t count = FittingOf(posts.back(), reached, std::span(stops).subspan(next));
      posts.push_back(count > 0 ? reached[count - 1] : PostIn(stops[next]));
      next += std::max<size_t>(count, 1);
    }
    return posts;
  }

  // How many of the stops one wall may pass: the last that fits, as if those before it did.
  static size_t FittingOf(const WallPost& from, const std::vector<WallPost>& reached,
                          std::span<const Stop> stops) {
    if (reached.empty()) return 0;
    size_t fits = 1, fails = reached.size() + 1;
    if (Fits(from, reached.back(), stops.first(reached.size() - 1))) return reached.size();
    while (fails - fits > 1) {
      const size_t middle = fits + (fails - fits) / 2;
      (Fits(from, reached[middle - 1], stops.first(middle - 1)) ? fits : fails) = middle;
    }
    return fits;
  }

  Stop StopAt(const ContourGate& gate) const {
    const DVec2 left = PlaceOf(gate.left), right = PlaceOf(gate.right);
    Stop stop{.left_end = glm::mix(left, right, kGateMargin),
              .right_end = glm::mix(right, left, kGateMargin)};
    stop.to_left = left - right;
    stop.left = HeightAt(gate.left, gate.right, -1);
    stop.right = HeightAt(gate.right, gate.left, 1);
    return stop;
  }

  // What the other map has there as well: two samples, and nothing of their neighbours.
  Stop BorderStop(const ContourGate& gate) const {
    const DVec2 middle = 0.5 * (PlaceOf(gate.left) + PlaceOf(gate.right));
    return {.left_end = middle,
            .right_end = middle,
            .left = {grid_.At(gate.left.x, gate.left.y)},
            .right = {grid_.At(gate.right.x, gate.right.y)},
            .to_left = PlaceOf(gate.left) - PlaceOf(gate.right)};
  }

  // The middle of a cell, where the surfaces are what those of its samples say that no edge parts.
  Stop StopIn(GridCorner cell, const ContourGate& gate) const {
    const DVec2 middle = PlaceOf(cell) + 0.5;
    return {.left_end = middle,
            .right_end = middle,
            .left = {MeanAround(cell, gate.left)},
            .right = {MeanAround(cell, gate.right)}};
  }

  double MeanAround(GridCorner cell, GridCorner corner) const {
    const auto [x, y] = cell;
    const std::array<GridCorner, 4> corners = {cell, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}};
    const int code = edges_.Code(x, y);
    int at = 0;
    while (corners[at].x != corner.x || corners[at].y != corner.y) ++at;
    unsigned together = 1u << at;
    for (int k = at; !(code >> k & 1) && (k + 1) % 4 != at; k = (k + 1) % 4) {
      together |= 1u << (k + 1) % 4;
    }
    for (int k = (at + 3) % 4; !(code >> k & 1) && k != at; k = (k + 3) % 4) together |= 1u << k;
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
      if (together >> k & 1) sum += grid_.At(corners[k].x, corners[k].y);
    }
    return sum / std::popcount(together);
  }

  // What nearness changes by from behind `from` to it, as seen from `to`; 0 where an edge is there.
  double SlopeTowards(GridCorner from, GridCorner to) const {
    const GridCorner behind{2 * from.x - to.x, 2 * from.y - to.y};  // below 0 it is far above
    if (behind.x >= grid_.width() || behind.y >= grid_.height()) return 0.0;
    const GridCorner first{std::min(from.x, behind.x), std::min(from.y, behind.y)};
    const bool is_edge =
        from.y == behind.y ? edges_.right(first.x, first.y) : edges_.below(first.x, first.y);
    const float here = grid_.At(from.x, from.y);
    if (is_edge || here == grid_.nothing()) return 0.0;
    const double most = kMaxWallSlope * grid_.PixelWidth(here);
    return std::clamp(double{here} - grid_.At(behind.x, behind.y), -most, most);
  }

  // The surface at `from` where a wall half the way to `other` meets it: a near one at its last
  // sample, a far one half the way on.
  Height HeightAt(GridCorner from, GridCorner other, double left_sign) const {
    const double here = grid_.At(from.x, from.y), there = grid_.At(other.x, other.y);
    if (here == grid_.nothing()) return {here};
    const double slope = SlopeTowards(from, other);
    const double tolerance =
        kWallTolerance * (grid_.PixelWidth(grid_.At(from.x, from.y)) + 0.5 * std::abs(slope));
    // A wall that stands out of a near surface shades it; one that begins below leaves a gap that
    // only rays along the surface find.
    const double near = std::max(here - kNearSink * std::abs(slope), there);
    return {.value = here < there ? std::min(here + 0.5 * slope, there) : near,
            .tolerance = tolerance,
            .towards_left = left_sign * slope};
  }

  const VolumeGrid& grid_;
  const EdgeMap& edges_;
};

// A triangle of which two corners are one place covers nothing.
void AddTriangle(VolumeTriangles& mesh, uint32_t a, uint32_t b, uint32_t c) {
  const auto same = [&](uint32_t i, uint32_t k) { return mesh.vertices[i] == mesh.vertices[k]; };
  if (same(a, b) || same(b, c) || same(c, a)) return;
  mesh.indices.insert(mesh.indices.end(), {a, b, c});
}

}  // namespace

std::vector<WallPost> FitWall(const VolumeGrid& grid, const EdgeMap& edges,
                              const Contour& contour) {
  return Fitter(grid, edges).Fit(contour);
}

void AddWalls(const VolumeGrid& grid, const EdgeMap& all_edges, VolumeTriangles& mesh) {
  const EdgeMap edges = WallEdges(grid, all_edges);
  for (const Contour& contour : TraceContours(grid, edges)) {
    const std::vector<WallPost> posts = FitWall(grid, edges, contour);
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    for (const WallPost& post : posts) {
      mesh.vertices.emplace_back(grid.WorldAt(post.left_at(), post.left));
      mesh.vertices.emplace_back(grid.WorldAt(post.right_at(), post.right));
    }
    for (uint32_t i = first; i + 2 < mesh.vertices.size(); i += 2) {
      const uint32_t left = i, right = i + 1, next_left = i + 2, next_right = i + 3;
      if (grid.is_right_handed()) {
        AddTriangle(mesh, left, right, next_right);
        AddTriangle(mesh, left, next_right, next_left);
      } else {
        AddTriangle(mesh, left, next_right, right);
        AddTriangle(mesh, left, next_left, next_right);
      }
    }
  }
}

}  // namespace penumbra
