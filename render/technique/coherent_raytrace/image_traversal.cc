#include "render/technique/coherent_raytrace/image_traversal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace penumbra {
namespace {

// By which a hidden part of a ray is taken to be longer at both ends: another image may show a
// surface on the other side of its edge.
constexpr double kMorePixels = 1.5;

double PixelsInS(const ImageRay& ray, double pixels) {
  return pixels / std::max(1e-30, glm::length(DVec2(ray.step())));
}

}  // namespace

std::optional<double> ImageTraversal::Trace(const DepthPyramid& image, const ImageRay& ray,
                                            WayInterval s, absl::FunctionRef<bool(double s)> stands,
                                            std::vector<WayInterval>& hidden) {
  image_ = &image;
  stands_ = &stands;
  s_ = s;
  origin_ = Vec3(ray.start() + s.from * ray.step());
  way_ = Vec3((s.to - s.from) * ray.step());
  side_ = Side::kUnknown;
  hidden_.clear();
  if (Visit({0.0f, 1.0f, image.top(), 0, 0})) return ParameterAt(blocked_at_);
  if (hidden_.empty()) return std::nullopt;
  const double more = PixelsInS(ray, kMorePixels);
  for (const Piece& piece : hidden_) {
    const double from = std::max(s.from, ParameterAt(piece.from) - more);
    const double to = std::min(s.to, ParameterAt(piece.to) + more);
    if (&piece != &hidden_.front() && hidden.back().to >= from) {
      hidden.back().to = to;
    } else {
      hidden.push_back({from, to});
    }
  }
  return std::nullopt;
}

bool ImageTraversal::Visit(Piece piece) {
  ++steps_;
  const DepthPyramid::Node node = image_->At(piece.level, piece.x, piece.y);
  float enter = NearnessAt(piece.from), leave = NearnessAt(piece.to);
  if (std::min(enter, leave) > node.near) return Enter(Side::kBefore, piece);
  if (std::max(enter, leave) < node.far) return Enter(Side::kBehind, piece);
  const bool is_floor = piece.level == 0;
  if (is_floor && !(node.near > 0)) return Enter(Side::kBefore, piece);
  const auto place_of = [&](float nearness) {
    if (way_.z == 0) return piece.from;
    return std::clamp((nearness - origin_.z) / way_.z, piece.from, piece.to);
  };
  if (uses_surfaces_ && !is_floor && std::min(enter, leave) < node.far &&
      std::max(enter, leave) > node.near && image_->IsOneSurface(piece.level, piece.x, piece.y) &&
      BlockAt(place_of(0.5f * (node.far + node.near)))) {
    return true;
  }
  if (!is_floor && (!clips_ || way_.z == 0)) return VisitChildren(piece);
  // Only what is neither nearer nor further than all of the node; of a floor that is where the ray
  // goes through it.
  float first = place_of(node.far), last = place_of(node.near);
  const bool rises = way_.z > 0;
  if (!rises) std::swap(first, last);
  Piece part = piece;
  if (first > piece.from) {
    part.to = first;
    if (Enter(rises ? Side::kBehind : Side::kBefore, part)) return true;
  }
  part.from = first, part.to = last;
  if (is_floor ? BlockAt(first) : VisitChildren(part)) return true;
  if (!(last < piece.to)) return false;
  part.from = last, part.to = piece.to;
  return Enter(rises ? Side::kBefore : Side::kBehind, part);
}

// In the order in which the ray meets them.
bool ImageTraversal::VisitChildren(const Piece& piece) {
  const int child_side = 1 << (piece.level - 1);
  const Vec2 middle(static_cast<float>((2 * piece.x + 1) * child_side),
                    static_cast<float>((2 * piece.y + 1) * child_side));
  const auto crossing = [&](int axis) {
    if (way_[axis] == 0) return piece.to;
    return std::clamp((middle[axis] - origin_[axis]) / way_[axis], piece.from, piece.to);
  };
  const float a = crossing(0), b = crossing(1);
  const std::array<float, 4> ends{piece.from, std::min(a, b), std::max(a, b), piece.to};
  for (int i = 0; i < 3; ++i) {
    const bool is_last = i == 2 || ends[i + 1] == piece.to;
    if (!(ends[i] < ends[i + 1]) && !(i == 0 && piece.from == piece.to)) continue;
    const Vec2 at = Vec2(origin_) + 0.5f * (ends[i] + ends[i + 1]) * Vec2(way_);
    const int x = 2 * piece.x + (at.x >= middle.x), y = 2 * piece.y + (at.y >= middle.y);
    if (x < image_->width(piece.level - 1) && y < image_->height(piece.level - 1) &&
        Visit({ends[i], ends[i + 1], piece.level - 1, x, y})) {
      return true;
    }
    if (is_last) break;
  }
  return false;
}

bool ImageTraversal::BlockAt(float at) {
  if (!(*stands_)(ParameterAt(at))) return false;
  blocked_at_ = at;
  return true;
}

bool ImageTraversal::Enter(Side side, const Piece& piece) {
  if (side_ != Side::kUnknown && side != side_ && HasWall(piece) && BlockAt(piece.from)) {
    return true;
  }
  side_ = side;
  last_ = piece;
  if (side == Side::kBehind) {
    if (!hidden_.empty() && hidden_.back().to == piece.from) {
      hidden_.back().to = piece.to;
    } else {
      hidden_.push_back(piece);
    }
  }
  return false;
}

// The nearness of the piece's pixel at the place `at`.
float ImageTraversal::PixelIn(const Piece& piece, float at, int& x, int& y) const {
  const auto pixel = [&](int axis, int node, int size) {
    const int first = node << piece.level;
    const int last = std::min(((node + 1) << piece.level) - 1, size - 1);
    return std::clamp(static_cast<int>(std::floor(origin_[axis] + at * way_[axis])), first, last);
  };
  x = pixel(0, piece.x, image_->width(0)), y = pixel(1, piece.y, image_->height(0));
  return image_->At(0, x, y).near;
}

// Between the pixels on both sides of where the ray comes into the piece.
bool ImageTraversal::HasWall(const Piece& piece) const {
  int x0, y0, x1, y1;
  const float before = PixelIn(last_, piece.from, x0, y0);
  const float after = PixelIn(piece, piece.from, x1, y1);
  if (x0 == x1 && y0 == y1) return before > 0;  // through the floor, within rounding
  return image_->AreJoined(before, after);
}

bool ImageTraversal::IsOpenAt(const DepthPyramid& image, const ImageRay& ray, WayInterval seen,
                              double s) {
  const double more = PixelsInS(ray, kMorePixels);
  const double from = std::max(seen.from, s - more), to = std::min(seen.to, s + more);
  const Vec3 origin(ray.start() + from * ray.step()), way((to - from) * ray.step());
  const int size[2] = {image.width(0), image.height(0)};
  int pixel[2], step[2];
  float next[2], per_pixel[2];  // where the ray leaves the pixel, in shares of the way
  for (int axis = 0; axis < 2; ++axis) {
    pixel[axis] = std::clamp(static_cast<int>(std::floor(origin[axis])), 0, size[axis] - 1);
    step[axis] = way[axis] < 0 ? -1 : 1;
    per_pixel[axis] = way[axis] == 0 ? 2.0f : 1 / std::abs(way[axis]);
    const float edge = static_cast<float>(pixel[axis] + (step[axis] > 0));
    next[axis] = way[axis] == 0 ? 2.0f : (edge - origin[axis]) / way[axis];
  }
  for (float enter = 0.0f; enter < 1;) {
    ++steps_;
    const int axis = next[0] < next[1] ? 0 : 1;
    const float leave = std::min(next[axis], 1.0f);
    const float furthest = origin.z + (way.z < 0 ? leave : enter) * way.z;
    if (!(furthest > image.At(0, pixel[0], pixel[1]).near)) return false;
    pixel[axis] += step[axis];
    if (pixel[axis] < 0 || pixel[axis] >= size[axis]) return true;
    enter = next[axis];
    next[axis] += per_pixel[axis];
  }
  return true;
}

}  // namespace penumbra
