#include "render/artifact/unoccluded_texture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include "render/math/parallel_for.h"

namespace penumbra {
namespace {

// Of the error bound, what is left to interpolation; the rest covers S where it is a limit.
constexpr double kInterpolationShare = 0.98;

// Interpolating has to save half of the points to be worth its while.
constexpr double kMostPoints = 0.5;

// Blocks are quartered down to this side where a whole one cannot be interpolated.
constexpr uint32_t kLeastSide = 8;

// Nearer to a planar light's plane than this part of their distance, F / c loses digits.
constexpr double kInPlane = 1e-7;

struct Position {
  uint32_t cell;
  double in_cell;
};

// Where the texels of a block lie among its cells, along one side.
std::vector<Position> Positions(uint32_t texels, uint32_t cells) {
  std::vector<Position> positions(texels, {0, 0.0});
  for (uint32_t i = 1; i < texels; ++i) {
    const double at = static_cast<double>(i) * cells / (texels - 1);
    const uint32_t cell = std::min(static_cast<uint32_t>(at), cells - 1);
    positions[i] = {cell, at - cell};
  }
  return positions;
}

double HalfWidth(DVec3 u, DVec3 v, DVec3 direction) {
  return 0.5 * (std::abs(glm::dot(u, direction)) + std::abs(glm::dot(v, direction)));
}

AreaLight SmoothLight(const AreaLight& light) {
  AreaLight smooth = light;
  if (auto* rectangle = std::get_if<RectangleLight>(&smooth.shape)) rectangle->two_sided = true;
  if (auto* disk = std::get_if<DiskLight>(&smooth.shape)) disk->two_sided = true;
  if (const auto* spot = std::get_if<SpotLight>(&light.shape)) {
    smooth.shape = PointLight{.position = spot->position};
  }
  return smooth;
}

}  // namespace

UnoccludedTexture::UnoccludedTexture(const AreaLight& light, const ReceiverPatch& receiver,
                                     double relative_error)
    : light_(light),
      receiver_(receiver),
      relative_error_(relative_error),
      extent_(light),
      is_smooth_(relative_error > 0),
      smooth_light_(SmoothLight(light)) {
  const DVec3 u(receiver.patch.edge_u), v(receiver.patch.edge_v);
  step_u_ = u / static_cast<double>(receiver.width);
  step_v_ = v / static_cast<double>(receiver.height);
  origin_ = DVec3(receiver.patch.origin) + 0.5 * step_u_ + 0.5 * step_v_;
  normal_ = glm::normalize(glm::cross(u, v));
  is_lit_behind_ = receiver.two_sided;
  if (const auto* spot = std::get_if<SpotLight>(&light.shape)) cone_.emplace(*spot);
  if (extent_.is_at_infinity()) return;
  const auto [low, high] = extent_.Height(origin_, normal_);
  is_lit_in_front_ = high > 0;
  is_lit_behind_ = is_lit_behind_ && low < 0;
  nearest_height_ = std::max({0.0, low, -high});
  power_ = extent_.plane() ? 4 : 3;
  if (std::holds_alternative<SphereLight>(light.shape)) {
    is_smooth_ = is_smooth_ && nearest_height_ > 0;
    nearest_height_ = std::abs(0.5 * (low + high));
  }
}

double UnoccludedTexture::Exact(DVec3 point) const {
  double factor = 0;
  if (is_lit_in_front_) factor += UnoccludedFactor(light_, point, normal_);
  if (is_lit_behind_) factor += UnoccludedFactor(light_, point, -normal_);
  return factor;
}

double UnoccludedTexture::Smooth(DVec3 point) const {
  double factor = 0;
  if (is_lit_in_front_) factor += UnoccludedFactor(smooth_light_, point, normal_);
  if (is_lit_behind_) factor += UnoccludedFactor(smooth_light_, point, -normal_);
  if (!extent_.plane()) return factor;
  const LightExtent::Plane& plane = *extent_.plane();
  const double distance = std::abs(glm::dot(plane.normal, point - plane.point));
  const double scale = glm::length(point - plane.point);
  if (distance > kInPlane * scale) return factor / distance;
  // The limit, from both sides along the patch.
  const DVec3 across = plane.normal - glm::dot(plane.normal, normal_) * normal_;
  const double sine2 = glm::dot(across, across);
  if (sine2 < 1e-6) return distance > 0 ? factor / distance : 0;
  const DVec3 aside = 10 * kInPlane * scale / sine2 * across;
  return 0.5 * (Smooth(point + aside) + Smooth(point - aside));
}

double UnoccludedTexture::Kinked(DVec3 point) const {
  if (cone_) {
    const DVec3 from_light = point - extent_.center();
    const double length = glm::length(from_light);
    return length > 0 ? cone_->Falloff(from_light / length) : 0;
  }
  if (!extent_.plane()) return 1;
  const LightExtent::Plane& plane = *extent_.plane();
  const double distance = glm::dot(plane.normal, point - plane.point);
  return plane.two_sided ? std::abs(distance) : std::max(0.0, distance);
}

UnoccludedTexture::Nearness UnoccludedTexture::NearnessOf(const TexelBlock& block) const {
  const DVec3 u = (block.width - 1.0) * step_u_, v = (block.height - 1.0) * step_v_;
  const DVec3 middle = At(block.x, block.y) + 0.5 * u + 0.5 * v;
  const double half_diagonal = 0.5 * std::max(glm::length(u + v), glm::length(u - v));
  const DVec3 to_light = extent_.center() - middle;
  // A sphere's factor is that of its centre.
  const bool has_width = extent_.plane().has_value();
  const auto sharpness = [&](DVec3 step) {
    const DVec3 e = glm::normalize(step), across = glm::cross(normal_, e);
    const double width_e = has_width ? extent_.HalfWidth(e) : 0;
    const double width_across = has_width ? extent_.HalfWidth(across) : 0;
    const double along = std::abs(glm::dot(to_light, e)) + width_e + HalfWidth(u, v, e);
    const double aside = std::max(
        0.0, std::abs(glm::dot(to_light, across)) - width_across - HalfWidth(u, v, across));
    const double rest2 = nearest_height_ * nearest_height_ + aside * aside;
    const double cos2 = along > 0 ? along * along / (along * along + rest2) : 0;
    return power_ * std::max(1.0, (power_ + 2) * cos2 - 1);
  };
  return {.distance = std::max(nearest_height_, extent_.Distance(middle) - half_diagonal),
          .sharpness_u = sharpness(step_u_),
          .sharpness_v = sharpness(step_v_)};
}

UnoccludedTexture::Cells UnoccludedTexture::CellsFor(const TexelBlock& block) const {
  if (!is_smooth_) return {};
  const double most = kMostPoints * block.width * block.height;
  Cells cells{1, 1};
  const auto points = [&cells] { return (cells.along_u + 1.0) * (cells.along_v + 1.0); };
  if (power_ == 0) return points() <= most ? cells : Cells{};
  const auto [distance, sharpness_u, sharpness_v] = NearnessOf(block);
  if (!(distance > 0)) return {};
  const double side_u = (block.width - 1.0) * glm::length(step_u_);
  const double side_v = (block.height - 1.0) * glm::length(step_v_);
  const double bound = 8 * kInterpolationShare * relative_error_ * distance * distance;
  while (points() <= most) {
    const double a = side_u / cells.along_u, b = side_v / cells.along_v;
    const double growth = std::pow(1 + (a + b) / distance, power_);
    const double share_u = a * a * sharpness_u * growth, share_v = b * b * sharpness_v * growth;
    if (share_u + share_v <= bound) return cells;
    // Towards equal shares of half the bound each, at least one cell more.
    (share_u > share_v ? cells.along_u : cells.along_v) += 1;
  }
  return {};
}

void UnoccludedTexture::FillExactly(const TexelBlock& block, std::span<float> factors,
                                    uint32_t stride) const {
  for (uint32_t j = 0; j < block.height; ++j) {
    for (uint32_t i = 0; i < block.width; ++i) {
      factors[size_t{j} * stride + i] = static_cast<float>(Exact(At(block.x + i, block.y + j)));
    }
  }
}

void UnoccludedTexture::Interpolate(const TexelBlock& block, Cells cells, std::span<float> factors,
                                    uint32_t stride) const {
  const uint32_t columns = cells.along_u + 1, rows = cells.along_v + 1;
  std::vector<double> points(size_t{columns} * rows);
  for (uint32_t r = 0; r < rows; ++r) {
    for (uint32_t c = 0; c < columns; ++c) {
      const double i = static_cast<double>(c) * (block.width - 1) / cells.along_u;
      const double j = static_cast<double>(r) * (block.height - 1) / cells.along_v;
      points[r * columns + c] = Smooth(At(block.x + i, block.y + j));
    }
  }
  const std::vector<Position> across = Positions(block.width, cells.along_u);
  const std::vector<Position> down = Positions(block.height, cells.along_v);
  std::vector<double> line(columns);
  for (uint32_t j = 0; j < block.height; ++j) {
    const double* const upper = &points[size_t{down[j].cell} * columns];
    for (uint32_t c = 0; c < columns; ++c) {
      line[c] = std::lerp(upper[c], upper[c + columns], down[j].in_cell);
    }
    for (uint32_t i = 0; i < block.width; ++i) {
      const auto [cell, in_cell] = across[i];
      const double smooth = line[cell] + in_cell * (line[cell + 1] - line[cell]);
      factors[size_t{j} * stride + i] =
          static_cast<float>(Kinked(At(block.x + i, block.y + j)) * smooth);
    }
  }
}

void UnoccludedTexture::Fill(const TexelBlock& block, std::span<float> factors,
                             uint32_t stride) const {
  const Cells cells = CellsFor(block);
  if (cells.along_u > 0) return Interpolate(block, cells, factors, stride);
  if (!is_smooth_ || (block.width <= kLeastSide && block.height <= kLeastSide)) {
    return FillExactly(block, factors, stride);
  }
  const uint32_t left = (block.width + 1) / 2, top = (block.height + 1) / 2;
  for (const uint32_t y : {0u, top}) {
    for (const uint32_t x : {0u, left}) {
      const TexelBlock part{block.x + x, block.y + y, x ? block.width - left : left,
                            y ? block.height - top : top};
      if (part.width == 0 || part.height == 0) continue;
      Fill(part, factors.subspan(size_t{y} * stride + x), stride);
    }
  }
}

void UnoccludedTexture::ForEachBlock(
    const std::stop_token& stop,
    const std::function<void(const TexelBlock&, std::span<const float>)>& shade) const {
  const uint32_t columns = (receiver_.width + kBlockSide - 1) / kBlockSide;
  const uint32_t rows = (receiver_.height + kBlockSide - 1) / kBlockSide;
  ParallelFor(size_t{columns} * rows, [&](size_t index) {
    if (stop.stop_requested()) return;
    TexelBlock block{.x = static_cast<uint32_t>(index % columns) * kBlockSide,
                     .y = static_cast<uint32_t>(index / columns) * kBlockSide};
    block.width = std::min(kBlockSide, receiver_.width - block.x);
    block.height = std::min(kBlockSide, receiver_.height - block.y);
    std::vector<float> factors(size_t{block.width} * block.height);
    Fill(block, factors, block.width);
    shade(block, factors);
  });
}

}  // namespace penumbra
