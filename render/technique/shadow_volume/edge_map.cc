#include "render/technique/shadow_volume/edge_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/technique/shadow_volume/edge_kernel.h"

namespace penumbra {
namespace {

// Two neighbours, the second one step along x or y from the first.
struct Gate {
  uint32_t x, y;
  bool is_right;  // the step is along x
};

// The sides of cell (x, y) in the order of its code.
std::array<Gate, 4> SidesOf(uint32_t x, uint32_t y) {
  return {Gate{x, y, true}, Gate{x + 1, y, false}, Gate{x, y + 1, true}, Gate{x, y, false}};
}

// By how much, as a part of it, differences of one slope differ.
constexpr float kMostBend = 0.25f;

class Detector {
 public:
  Detector(const VolumeGrid& grid, const EdgeThresholds& thresholds)
      : grid_(grid), thresholds_(thresholds), edges_(grid) {}

  void MarkAll();
  void MarkIds(std::span<const uint32_t> ids);
  void FollowDangling();
  EdgeMap Finish() { return std::move(edges_); }

 private:
  // What the difference of nearness is, along the gate's axis, `steps` gates further on; 0 beyond
  // the map.
  float Difference(Gate gate, int steps) const;
  bool IsMaximum(Gate gate, float second) const;
  // Whether it is one of three differences in a row that are nearly the same.
  bool IsSlope(Gate gate) const;
  // A pixel's width at the nearer of the gate's samples.
  float WidthAt(Gate gate) const {
    return grid_.PixelWidth(std::max(grid_.At(gate.x, gate.y),
                                     grid_.At(gate.x + gate.is_right, gate.y + !gate.is_right)));
  }
  void Refine(uint64_t* words, const std::vector<uint64_t>& high, uint32_t y, bool is_right);
  void FollowFrom(uint32_t x, uint32_t y, std::vector<Gate>& open);
  bool IsInside(uint32_t x, uint32_t y) const {
    return x + 1 < grid_.width() && y + 1 < grid_.height();
  }

  const VolumeGrid& grid_;
  const EdgeThresholds thresholds_;
  EdgeMap edges_;
};

float Detector::Difference(Gate gate, int steps) const {
  const int64_t x = int64_t{gate.x} + (gate.is_right ? steps : 0);
  const int64_t y = int64_t{gate.y} + (gate.is_right ? 0 : steps);
  const int64_t x1 = x + (gate.is_right ? 1 : 0), y1 = y + (gate.is_right ? 0 : 1);
  if (x < 0 || y < 0 || x1 >= grid_.width() || y1 >= grid_.height()) return 0.0f;
  const float a = grid_.At(static_cast<uint32_t>(x), static_cast<uint32_t>(y));
  const float b = grid_.At(static_cast<uint32_t>(x1), static_cast<uint32_t>(y1));
  return a == b ? 0.0f : b - a;
}

bool Detector::IsMaximum(Gate gate, float second) const {
  const float here = Difference(gate, 0);
  const float sign = here < 0 ? -1.0f : 1.0f;
  const float slack = second * WidthAt(gate);
  const float before = sign * Difference(gate, -1), after = sign * Difference(gate, 1);
  if (before < 0 && after < 0) return true;
  // A step the other way says nothing of whether this is one.
  const float over_before = before < 0 ? 0 : std::abs(here) - before;
  const float over_after = after < 0 ? 0 : std::abs(here) - after;
  return std::min(over_before, over_after) > -slack && std::max(over_before, over_after) > slack;
}

bool Detector::IsSlope(Gate gate) const {
  const float here = Difference(gate, 0), most = kMostBend * std::abs(here);
  if (std::isinf(here)) return false;  // from infinitely far to nothing
  const auto is_same = [&](int steps) { return std::abs(here - Difference(gate, steps)) <= most; };
  const bool before = is_same(-1), after = is_same(1);
  if (before && after) return true;
  // A slope that comes to its vanishing line within the next step ends here, whatever is behind it.
  const float further =
      std::min(grid_.At(gate.x, gate.y), grid_.At(gate.x + gate.is_right, gate.y + !gate.is_right));
  if (!grid_.from_infinity() && further < std::abs(here)) return false;
  return (before && is_same(-2)) || (after && is_same(2));
}

// Of what is marked in a row, in `words`, candidates have to be maxima, and the others not be a
// slope.
void Detector::Refine(uint64_t* words, const std::vector<uint64_t>& high, uint32_t y,
                      bool is_right) {
  const float second = thresholds_.second * thresholds_.low;
  for (uint32_t word = 0; word < edges_.words(); ++word) {
    for (uint64_t bits = words[word]; bits != 0; bits &= bits - 1) {
      const int bit = std::countr_zero(bits);
      const Gate gate{64 * word + static_cast<uint32_t>(bit), y, is_right};
      const bool is_sure = high[word] >> bit & 1;
      if (is_sure ? IsSlope(gate) : !IsMaximum(gate, second)) {
        words[word] &= ~(uint64_t{1} << bit);
      }
    }
  }
}

// Bits below `count`, from bit 64 · word on.
uint64_t BitsBelow(uint32_t count, uint32_t word) {
  if (count <= 64 * word) return 0;
  return count - 64 * word >= 64 ? ~uint64_t{0} : (uint64_t{1} << (count - 64 * word)) - 1;
}

void Detector::MarkAll() {
  // One below 1, so that what is there and what is not always differ.
  constexpr float kMost = 0.999f;
  const auto limit = [&](float threshold) {
    const float scaled = threshold * grid_.pixel();
    return grid_.from_infinity() ? scaled : std::min(scaled, kMost);
  };
  const EdgeLimits limits{.low = limit(std::min(thresholds_.low, thresholds_.high)),
                          .high = limit(thresholds_.high),
                          .from_infinity = grid_.from_infinity()};
  const bool is_plain = thresholds_.high <= thresholds_.low;
  std::vector<uint64_t> right_high(edges_.words()), below_high(edges_.words());
  for (uint32_t y = 0; y < grid_.height(); ++y) {
    const bool is_last = y + 1 == grid_.height();
    uint64_t *right = edges_.RightWords(y), *below = edges_.BelowWords(y);
    MarkDifferences(grid_.Row(y), grid_.Row(is_last ? y : y + 1), edges_.words(), limits,
                    {right, right_high.data(), below, below_high.data()});
    for (uint32_t word = 0; word < edges_.words(); ++word) {
      right[word] &= BitsBelow(grid_.width() - 1, word);
      below[word] &= BitsBelow(grid_.width(), word);
    }
    if (is_plain) continue;
    Refine(right, right_high, y, true);
    Refine(below, below_high, y, false);
  }
}

void Detector::MarkIds(std::span<const uint32_t> ids) {
  const uint32_t ring = grid_.first_cell() == 0 ? 1 : 0;
  const uint32_t width = grid_.width() - 2 * ring, height = grid_.height() - 2 * ring;
  if (ids.size() != size_t{width} * height) return;
  for (uint32_t y = 0; y < height; ++y) {
    const uint32_t* row = &ids[size_t{y} * width];
    for (uint32_t x = 0; x < width; ++x) {
      if (x + 1 < width && row[x] != row[x + 1]) edges_.SetRight(x + ring, y + ring);
      if (y + 1 < height && row[x] != row[x + width]) edges_.SetBelow(x + ring, y + ring);
    }
  }
}

// Flags one more side of a cell that has one, and puts it on `open`.
void Detector::FollowFrom(uint32_t x, uint32_t y, std::vector<Gate>& open) {
  const int code = edges_.Code(x, y);
  if (std::popcount(static_cast<unsigned>(code)) != 1) return;
  const float low = thresholds_.dangling * std::min(thresholds_.low, thresholds_.high);
  int best = -1;
  float most = low;
  const std::array<Gate, 4> sides = SidesOf(x, y);
  for (int side = 0; side < 4; ++side) {
    if (code >> side & 1) continue;
    const Gate gate = sides[side];
    const float difference = std::abs(Difference(gate, 0)) / WidthAt(gate);
    if (difference > most && IsMaximum(gate, thresholds_.second * low)) {
      most = difference;
      best = side;
    }
  }
  if (best < 0) return;
  edges_.SetSide(x, y, best);
  open.push_back(sides[best]);
}

void Detector::FollowDangling() {
  std::vector<Gate> open;
  const auto follow_beside = [&](Gate gate) {
    const uint32_t back_x = gate.is_right ? 0 : 1, back_y = gate.is_right ? 1 : 0;
    if (IsInside(gate.x, gate.y)) FollowFrom(gate.x, gate.y, open);
    if (gate.x < back_x || gate.y < back_y) return;
    if (IsInside(gate.x - back_x, gate.y - back_y)) {
      FollowFrom(gate.x - back_x, gate.y - back_y, open);
    }
  };
  std::vector<Gate> ends;
  edges_.ForEachCell([&](uint32_t x, uint32_t y, int code) {
    if (std::popcount(static_cast<unsigned>(code)) != 1) return;
    ends.push_back(SidesOf(x, y)[static_cast<size_t>(std::countr_zero(unsigned(code)))]);
  });
  for (const Gate& end : ends) {
    follow_beside(end);
    while (!open.empty()) {
      const Gate gate = open.back();
      open.pop_back();
      follow_beside(gate);
    }
  }
}

}  // namespace

EdgeMap::EdgeMap(const VolumeGrid& grid)
    : width_(grid.width()),
      height_(grid.height()),
      words_((grid.width() + 63) / 64),
      first_x_(grid.first_cell()),
      first_y_(grid.first_cell()),
      end_x_(grid.has_cells() ? grid.end_cell_x() : 0),
      end_y_(grid.has_cells() ? grid.end_cell_y() : 0),
      right_(size_t{words_} * height_),
      below_(size_t{words_} * height_) {
  const float nothing = grid.nothing();
  for (uint32_t y = 0; y < height_; ++y) {
    const float* const row = grid.Row(y);
    const float* const next = grid.Row(y + 1 < height_ ? y + 1 : y);
    uint32_t count = 0;
    for (uint32_t x = 0; x + 1 < width_; ++x)
      count += (row[x] != nothing) | (row[x + 1] != nothing);
    for (uint32_t x = 0; x < width_ && next != row; ++x) {
      count += (row[x] != nothing) | (next[x] != nothing);
    }
    place_count_ += count;
  }
}

void EdgeMap::SetSide(uint32_t x, uint32_t y, int side) {
  const Gate gate = SidesOf(x, y)[static_cast<size_t>(side)];
  gate.is_right ? SetRight(gate.x, gate.y) : SetBelow(gate.x, gate.y);
}

uint64_t EdgeMap::CellsWithEdges(uint32_t word, uint32_t y) const {
  const size_t row = size_t{y} * words_ + word;
  const uint64_t after = word + 1 < words_ ? below_[row + 1] << 63 : 0;
  const uint64_t any = right_[row] | right_[row + words_] | below_[row] | below_[row] >> 1 | after;
  return any & BitsBelow(end_x_, word) & ~BitsBelow(first_x_, word);
}

size_t EdgeMap::flag_count() const {
  size_t count = 0;
  for (const uint64_t word : right_) count += static_cast<size_t>(std::popcount(word));
  for (const uint64_t word : below_) count += static_cast<size_t>(std::popcount(word));
  return count;
}

double EdgeMap::fraction() const {
  if (place_count_ == 0) return 0.0;
  return static_cast<double>(flag_count()) / static_cast<double>(place_count_);
}

EdgeMap FindEdges(const VolumeGrid& grid, const EdgeOptions& options,
                  std::span<const uint32_t> ids) {
  if (!grid.has_cells()) return EdgeMap(grid);
  Detector detector(grid, options.thresholds ? *options.thresholds : ChooseThresholds(grid));
  detector.MarkAll();
  if (!ids.empty()) detector.MarkIds(ids);
  if (options.follows_dangling) detector.FollowDangling();
  return detector.Finish();
}

}  // namespace penumbra
