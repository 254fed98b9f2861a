#include "render/technique/shadow_volume/wall_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <span>
#include <utility>

#include "render/technique/shadow_volume/wall_edges.h"

namespace penumbra {
namespace {

double Cross(DVec2 a, DVec2 b) { return a.x * b.y - a.y * b.x; }
DVec2 PlaceOf(GridCorner corner) { return DVec2(corner.x, corner.y); }

// What a contour says at one place on its way.
struct Stop {
  DVec2 left_end, right_end;  // that it passes between; one place: that it passes through
  WallSide left, right;
};

WallPost::End EndOn(const WallSide& side, DVec2 at) {
  if (side.is_near) return {.at = side.at, .nearness = side.nearness};
  return {.at = at, .nearness = side.NearnessAt(at)};
}

WallPost PostOn(const Stop& stop, DVec2 at) {
  return {.at = at, .left = EndOn(stop.left, at), .right = EndOn(stop.right, at)};
}

WallPost PostIn(const Stop& stop) { return PostOn(stop, 0.5 * (stop.left_end + stop.right_end)); }

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
    return PostOn(stop, glm::mix(stop.right_end, stop.left_end, 0.5 * (first + last)));
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

// Whether a wall is as high as a surface where it passes it, `t` of its way.
bool Meets(const WallPost::End& from, const WallPost::End& to, double t, const WallSide& side) {
  if (std::isinf(side.nearness)) return true;
  const double over =
      std::lerp(from.nearness, to.nearness, t) - side.NearnessAt(glm::mix(from.at, to.at, t));
  return std::abs(over) <= side.tolerance;
}

// Whether the wall between two posts is as high as the surfaces at the stops between them.
bool Fits(const WallPost& from, const WallPost& to, std::span<const Stop> between) {
  const DVec2 way = to.at - from.at;
  for (const Stop& stop : between) {
    const DVec2 along = stop.left_end - stop.right_end, start = stop.right_end - from.at;
    const double across = Cross(way, along);
    if (across == 0) continue;
    const double t = Cross(start, along) / across;  // of the way
    if (!Meets(from.left, to.left, t, stop.left)) return false;
    if (!Meets(from.right, to.right, t, stop.right)) return false;
  }
  return true;
}

class Fitter {
 public:
  Fitter(const VolumeGrid& grid, const EdgeMap& edges) : sides_(grid, edges) {}

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
    return {.left_end = glm::mix(left, right, kGateMargin),
            .right_end = glm::mix(right, left, kGateMargin),
            .left = sides_.AtGate(gate.left, gate.right),
            .right = sides_.AtGate(gate.right, gate.left)};
  }

  Stop BorderStop(const ContourGate& gate) const {
    const DVec2 middle = 0.5 * (PlaceOf(gate.left) + PlaceOf(gate.right));
    return {.left_end = middle,
            .right_end = middle,
            .left = sides_.AtBorder(gate.left, gate.right),
            .right = sides_.AtBorder(gate.right, gate.left)};
  }

  Stop StopIn(GridCorner cell, const ContourGate& gate) const {
    const DVec2 middle = PlaceOf(cell) + 0.5;
    return {.left_end = middle,
            .right_end = middle,
            .left = sides_.InCell(cell, gate.left),
            .right = sides_.InCell(cell, gate.right)};
  }

  const WallSides sides_;
};

// A triangle of which two corners are one place covers nothing.
void AddTriangle(VolumeTriangles& mesh, uint32_t a, uint32_t b, uint32_t c) {
  const auto same = [&](uint32_t i, uint32_t k) { return mesh.vertices[i] == mesh.vertices[k]; };
  if (same(a, b) || same(b, c) || same(c, a)) return;
  mesh.indices.insert(mesh.indices.end(), {a, b, c});
}

// Counter-clockwise in (x, y).
void AddTurned(const VolumeGrid& grid, VolumeTriangles& mesh, uint32_t a, uint32_t b, uint32_t c) {
  if (!grid.is_right_handed()) std::swap(b, c);
  AddTriangle(mesh, a, b, c);
}

void AddWall(const VolumeGrid& grid, std::span<const WallPost> posts, VolumeTriangles& mesh) {
  const auto first = static_cast<uint32_t>(mesh.vertices.size());
  for (const WallPost& post : posts) {
    mesh.vertices.emplace_back(grid.WorldAt(post.left.at, post.left.nearness));
    mesh.vertices.emplace_back(grid.WorldAt(post.right.at, post.right.nearness));
  }
  for (uint32_t i = first; i + 2 < mesh.vertices.size(); i += 2) {
    const uint32_t left = i, right = i + 1, next_left = i + 2, next_right = i + 3;
    AddTurned(grid, mesh, left, right, next_right);
    AddTurned(grid, mesh, left, next_right, next_left);
  }
}

// What the ends of walls leave open in a cell, where the surfaces between them end.
void AddMeeting(const VolumeGrid& grid, const EdgeMap& edges, GridCorner cell,
                VolumeTriangles& mesh) {
  const WallSides sides(grid, edges);
  const auto [x, y] = cell;
  const std::array<GridCorner, 4> corners = {cell, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}};
  const int code = edges.Code(x, y);
  const auto first = static_cast<uint32_t>(mesh.vertices.size());
  for (size_t k = 0; k < 4; ++k) {
    if (!(code >> k & 1)) continue;  // the last corner of a surface
    const WallSide side = sides.InCell(cell, corners[k]);
    mesh.vertices.emplace_back(grid.WorldAt(side.at, side.nearness));
  }
  for (uint32_t i = first + 1; i + 1 < mesh.vertices.size(); ++i) {
    AddTurned(grid, mesh, first, i, i + 1);
  }
}

// Those in which contours begin or end, each once.
std::vector<GridCorner> MeetingsOf(std::span<const Contour> contours) {
  std::vector<GridCorner> cells;
  for (const Contour& contour : contours) {
    for (const auto& cell : {contour.first_cell, contour.last_cell}) {
      if (cell) cells.push_back(*cell);
    }
  }
  const auto key = [](const GridCorner& cell) { return std::pair(cell.y, cell.x); };
  std::ranges::sort(cells, {}, key);
  const auto are_one = [&key](const auto& a, const auto& b) { return key(a) == key(b); };
  cells.erase(std::unique(cells.begin(), cells.end(), are_one), cells.end());
  return cells;
}

}  // namespace

std::vector<WallPost> FitWall(const VolumeGrid& grid, const EdgeMap& edges,
                              const Contour& contour) {
  return Fitter(grid, edges).Fit(contour);
}

void AddWalls(const VolumeGrid& grid, const EdgeMap& all_edges, VolumeTriangles& mesh) {
  const EdgeMap edges = WallEdges(grid, all_edges);
  const std::vector<Contour> contours = TraceContours(grid, edges);
  for (const Contour& contour : contours) AddWall(grid, FitWall(grid, edges, contour), mesh);
  for (const GridCorner cell : MeetingsOf(contours)) AddMeeting(grid, edges, cell, mesh);
}

}  // namespace penumbra
