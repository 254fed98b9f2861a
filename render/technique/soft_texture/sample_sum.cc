#include "render/technique/soft_texture/sample_sum.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include "render/math/parallel_for.h"
#include "render/technique/soft_texture/receiver_transform.h"

namespace penumbra {
namespace {

constexpr double kPi = std::numbers::pi;

// As many rows share a cache line of each sample's words.
constexpr uint32_t kRowsPerTask = 16;

// Where a sample's surface faces, and what area it stands for.
struct Surface {
  DVec3 facing{0.0};
  double area = 0;
};

struct SurfaceAt {
  DVec3 point;
  DVec3 target;  // the middle of the patch
  uint32_t total;

  Surface operator()(const RectangleLight& light) const {
    const DVec3 across = glm::cross(DVec3(light.edge_u), DVec3(light.edge_v));
    const double area = glm::length(across);
    return {across / area, area};
  }
  Surface operator()(const DiskLight& light) const {
    return {glm::normalize(DVec3(light.normal)), kPi * light.radius * light.radius};
  }
  Surface operator()(const SphereLight& light) const {
    const DVec3 to_target = target - DVec3(light.center);
    const bool is_centered = glm::dot(to_target, to_target) == 0;
    const DVec3 axis = is_centered ? DVec3(0, 1, 0) : glm::normalize(to_target);
    const DVec3 out = glm::normalize(point - DVec3(light.center));
    const double largest = 2 * std::sqrt(static_cast<double>(total));
    const double per_disc_area = 1 / std::max(glm::dot(out, axis), 1 / largest);
    return {out, kPi * light.radius * light.radius * per_disc_area};
  }
  Surface operator()(const DistantLight& light) const {
    return {DVec3(0.0), 1 / glm::dot(point, glm::normalize(DVec3(light.to_light)))};
  }
  template <typename Point>
  Surface operator()(const Point&) const {
    return {};
  }
};

bool IsTwoSided(const LightShape& shape) {
  if (const auto* rectangle = std::get_if<RectangleLight>(&shape)) return rectangle->two_sided;
  if (const auto* disk = std::get_if<DiskLight>(&shape)) return disk->two_sided;
  return false;
}

HiddenRow RowIn(const BandShadows& band, uint32_t row) {
  if (band.shadows == nullptr) return {};
  return {.words = band.shadows->Row(band.first_sample, row - band.first_row),
          .sample_stride = band.shadows->sample_stride(),
          .column_stride = band.shadows->column_stride()};
}

}  // namespace

bool HasUnequalSamples(const AreaLight& light) { return EffectiveSampleCount(light, 2) > 1; }

SampleSum::SampleSum(const AreaLight& light, const ReceiverPatch& receiver, double surface_offset,
                     uint32_t total, bool sums_all)
    : light_(light),
      receiver_(receiver),
      surface_offset_(surface_offset),
      total_(total),
      stride_((receiver.width + 31) / 32 * 32),
      visible_(size_t{stride_} * receiver.height, 0.0f),
      all_(sums_all ? visible_.size() : 0, 0.0f) {
  const DVec3 u(receiver.patch.edge_u), v(receiver.patch.edge_v);
  x_ = glm::normalize(u);
  z_ = glm::normalize(glm::cross(u, v));
  y_ = glm::cross(z_, x_);
  const bool is_at_infinity = std::holds_alternative<DistantLight>(light.shape);
  const double step = is_at_infinity ? 0 : glm::length(u) / receiver.width;
  rule_ = {.step = static_cast<float>(step), .two_sided = IsTwoSided(light.shape)};
}

SampleSum::Sample SampleSum::Prepare(const LightSample& sample) const {
  const auto map = ReceiverTransform::Create(receiver_.patch, sample, surface_offset_);
  if (!map || (!receiver_.two_sided && map->sample_height() < 0)) return {};
  const DVec3 point(sample.point);
  const SurfaceAt surface_at{point, DVec3(receiver_.patch.At(Vec2(0.5f))), total_};
  const Surface surface = std::visit(surface_at, light_.shape);
  const DVec3 p = sample.at_infinity ? point : point - DVec3(receiver_.patch.origin);
  const auto in_frame = [this](DVec3 d) {
    return DVec3(glm::dot(d, x_), glm::dot(d, y_), glm::dot(d, z_));
  };
  const DVec3 place = in_frame(p);
  return {place, in_frame(surface.facing), surface.area * std::abs(place.z) / kPi};
}

// With q across the row, r² = t² + q² + z², and the vector from the sample to the texel is
// −(t, q, z).
TermRow SampleSum::RowOf(const Sample& sample, uint32_t row) const {
  const auto weight = static_cast<float>(sample.weight);
  if (std::holds_alternative<DistantLight>(light_.shape)) {
    return {.t = 0, .k = 1, .e = 1, .e_t = 0, .weight = weight};
  }
  const DVec3 v(receiver_.patch.edge_v);
  const double down = (row + 0.5) / receiver_.height;
  const double half_step = 0.5 * glm::length(DVec3(receiver_.patch.edge_u)) / receiver_.width;
  const double t = sample.place.x - down * glm::dot(v, x_) - half_step;
  const double q = sample.place.y - down * glm::dot(v, y_);
  const DVec3 facing = sample.facing;
  return {.t = static_cast<float>(t),
          .k = static_cast<float>(q * q + sample.place.z * sample.place.z),
          .e = static_cast<float>(-(facing.y * q + facing.z * sample.place.z)),
          .e_t = static_cast<float>(-facing.x),
          .weight = weight};
}

void SampleSum::AddBand(std::span<const LightSample> samples, const TexelWindow& window,
                        const BandShadows& hidden, const BandShadows& hidden_too,
                        const std::stop_token& stop) {
  std::vector<Sample> prepared;
  prepared.reserve(samples.size());
  for (const LightSample& sample : samples) prepared.push_back(Prepare(sample));
  const uint32_t rows = window.row_end - window.row_begin;
  ParallelFor((rows + kRowsPerTask - 1) / kRowsPerTask, [&](uint32_t task) {
    if (stop.stop_requested()) return;
    std::vector<TermRow> terms(prepared.size());
    const uint32_t begin = window.row_begin + task * kRowsPerTask;
    for (uint32_t row = begin; row < std::min(begin + kRowsPerTask, window.row_end); ++row) {
      std::transform(prepared.begin(), prepared.end(), terms.begin(),
                     [&](const Sample& sample) { return RowOf(sample, row); });
      const size_t at = size_t{row} * stride_;
      AddTermRow(terms, rule_, RowIn(hidden, row), RowIn(hidden_too, row),
                 {&visible_[at], all_.empty() ? nullptr : &all_[at]}, stride_ / 32);
    }
  });
}

}  // namespace penumbra
