#include "client/display/light_ranges.h"

#include <algorithm>

namespace penumbra {
namespace {

// Each loop of surface_glsl.cc and of what it calls counts its turns and one more, with which it
// ends. Of a light that nothing is known of all are passed once.
constexpr uint32_t kTurnsOfLight = 64;
// Fit and the five rings of texels of Coverage.
constexpr uint32_t kTurnsOfCandidate = 56;
// The four nearest texels of a face, whose loop goes on to its layers.
constexpr uint32_t kTexels = 4;
// Of both layers' texels, three times over them.
constexpr uint32_t kTurnsOfWidthFace = 32;
// Of what is not hidden, and of what a pixel of a picture is a share of.
constexpr uint32_t kFactors = 2;

// The most candidates that each light has on any surface.
std::vector<uint32_t> MostCandidates(const DrawList& list) {
  std::vector<uint32_t> most(list.lights.size(), 0);
  for (const DrawItem& item : list.items) {
    uint32_t run = 0;
    for (uint32_t c = item.first_candidate; c < item.end_candidate; ++c) {
      const uint32_t light = list.candidates[c].light;
      const bool is_same = c > item.first_candidate && list.candidates[c - 1].light == light;
      run = is_same ? run + 1 : 1;
      most[light] = std::max(most[light], run);
    }
  }
  return most;
}

}  // namespace

uint32_t TurnsOf(const AttenuationLdi& ldi) {
  uint32_t turns = 0;
  for (const LdiFace& face : ldi.faces) {
    uint32_t layers = 0;
    for (size_t pixel = 1; pixel < face.offsets.size(); ++pixel) {
      layers = std::max(layers, face.offsets[pixel] - face.offsets[pixel - 1]);
    }
    turns += 2 + kTexels * (layers + 2);
  }
  return turns;
}

uint32_t TurnsOf(const ShadowWidthMap& map) {
  return static_cast<uint32_t>(map.faces.size()) * kTurnsOfWidthFace;
}

std::vector<LightRange> LightRanges(const DrawList& list, std::span<const uint32_t> order,
                                    std::span<const uint32_t> turns_of_artifacts, size_t end) {
  const std::vector<uint32_t> candidates = MostCandidates(list);
  std::vector<LightRange> ranges(1);
  uint64_t sum = 0;
  for (size_t place = 0; place < end; ++place) {
    const uint32_t light = order[place];
    uint64_t turns = kTurnsOfLight + uint64_t{kTurnsOfCandidate} * candidates[light];
    if (light < turns_of_artifacts.size()) turns += turns_of_artifacts[light];
    turns += kFactors * TurnsOfFactor(list.lights[light]);
    if (sum > 0 && sum + turns > kMaxTurns) {
      ranges.push_back({.first = ranges.back().end, .end = ranges.back().end});
      sum = 0;
    }
    sum += turns;
    ++ranges.back().end;
  }
  return ranges;
}

uint32_t SkippedCandidates(const DrawList& list, const DrawItem& item,
                           std::span<const uint32_t> order, int first) {
  if (first == 0) return 0;
  const auto all = std::span(list.candidates)
                       .subspan(item.first_candidate, item.end_candidate - item.first_candidate);
  const uint32_t light = order[static_cast<size_t>(first)];
  return static_cast<uint32_t>(std::ranges::lower_bound(all, light, {}, &Candidate::light) -
                               all.begin());
}

}  // namespace penumbra
