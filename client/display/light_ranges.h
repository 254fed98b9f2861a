// How many lights a shader can add up at a time.
//
//   for (const LightRange& range : LightRanges(list, order, words.turns(), order.size())) …
//
// Mesa's software device ends every loop of a shader's run, without an error, once its loops
// together have made 65,535 turns, those within others and those of what is skipped included. The
// loops over lights, their candidates, layers and sides of disks get there with scenes of a few
// hundred disks, or of a wall of a few thousand receivers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "client/display/draw_list.h"
#include "render/artifact/attenuation_ldi.h"
#include "render/artifact/shadow_width_map.h"

namespace penumbra {

// What one run of a shader may make, with room for what is counted too low.
inline constexpr uint64_t kMaxTurns = 32'768;

// At most, of what an artifact has to say of a point.
uint32_t TurnsOf(const AttenuationLdi& ldi);
uint32_t TurnsOf(const ShadowWidthMap& map);

// Places in the order of lights.
struct LightRange {
  int first = 0, end = 0;  // past the last
};

// Lights [0, end) in ranges of as many as make no more than kMaxTurns on any surface, or of one.
// At least one range, which may be empty.
//
// order              all lights, in the order in which they are drawn (WordPool::Update)
// turns_of_artifacts of what each light of the scene has besides candidates; may be empty
std::vector<LightRange> LightRanges(const DrawList& list, std::span<const uint32_t> order,
                                    std::span<const uint32_t> turns_of_artifacts, size_t end);

// Candidates of the item of lights before the one that is drawn in the place `first`.
uint32_t SkippedCandidates(const DrawList& list, const DrawItem& item,
                           std::span<const uint32_t> order, int first);

}  // namespace penumbra
