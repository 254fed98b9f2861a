// Scripts of what sound clients say in a session, and one of what they do not.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/fuzz/kit/target.h"

namespace penumbra::fuzzing {

// Of a session's steps: a v1.SessionRequest, changed as such or as bytes.
enum SessionKind : uint8_t { kRequest, kBytes, kSessionKinds };

// What scripts call those in the room, whose ids are drawn.
inline constexpr char kMe[] = "me", kOther[] = "other";
// And the scene's incarnation and content hash, in so many bytes.
inline const std::string kIncarnation(16, 'i'), kContentHash(32, 'h');

std::vector<Seed> SessionRequestSeeds();

}  // namespace penumbra::fuzzing
