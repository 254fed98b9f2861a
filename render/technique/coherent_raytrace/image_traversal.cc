#include "render/technique/coherent_raytrace/image_traversal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace penumbra {
namespace {

// By which a hidden part of a ray is taken to be longer at both ends.
constexpr double kMorePixels = 1.5;

}  // namespace

std::optional<double> ImageTraversal::Trace(const DepthPyramid& image, const ImageRay& ray,
                                            WayInterval s, std::vector<WayInterval>& hidden) {
  image_ = &image;
  const double length = s.to - s.from;
  origin_ = Vec3(ray.start() + s.from * ray.step());
  way_ = Vec3(length * ray.step());
  side_ = Side::kUnknown;
  hidden_.clear();
  if (Visit({0.0f, 1.0f, image.top(), 0, 0})) return s.from + double{blocked_at_} * length;
  if (hidden_.empty()) return std::nullopt;
  const double pixel = kMorePixels / std::max(1e-30f, glm::length(Vec2(way_)));
  for (const Piece& piece : hidden_) {
    const double from = s.from + std::max(0.0, piece.from - pixel) * length;
    const double to = s.from + std::min(1.0, piece.to + pixel) * length;
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
  if (piece.level == 0) {
    if (!(node.near > 0)) return Enter(Side::kBefore, piece);
    const float at = way_.z == 0 ? piece.from : (node.near - origin_.z) / way_.z;
    return BlockAt(std::clamp(at, piece.from, piece.to));
  }
  if (uses_surfaces_ && std::min(enter, leave) < node.far && std::max(enter, leave) > node.near &&
      image_->IsOneSurface(piece.level, piece.x, piece.y)) {
    return BlockAt(
        std::clamp((0.5f * (node.far + node.near) - origin_.z) / way_.z, piece.from, piece.to));
  }
  if (!clips_ || way_.z == 0) return VisitChildren(piece);
  // Only what is neither nearer nor further than all of the node.
  float first = (node.far - origin_.z) / way_.z, last = (node.near - origin_.z) / way_.z;
  const bool rises = way_.z > 0;
  if (!rises) std::swap(first, last);
  first = std::clamp(first, piece.from, piece.to), last = std::clamp(last, first, piece.to);
  Piece part = piece;
  if (first > piece.from) {
    part.to = first;
    if (Enter(rises ? Side::kBehind : Side::kBefore, part)) return true;
  }
  part.from = first, part.to = last;
  if (VisitChildren(part)) return true;
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

bool ImageTraversal::Enter(Side side, const Piece& piece) {
  if (side_ != Side::kUnknown && side != side_ && HasWall(piece)) return BlockAt(piece.from);
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

}  // namespace penumbra
