// Scripts of what identity providers, operators and callers write of who somebody is.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/fuzz/kit/target.h"

namespace penumbra::fuzzing {

using Json = nlohmann::json;

// The header of the next claims; claims, which are signed; a byte of what was signed changed; an
// algorithm that a forger says; a token, a key set, a bearer token and identities as they are.
enum TokenKind : uint8_t {
  kHeader,
  kClaims,
  kChange,
  kAlgorithm,
  kToken,
  kKeySet,
  kBearer,
  kIdentities,
  kTokenKinds
};

inline constexpr int64_t kNow = 1'800'000'000;  // seconds since 1970
inline constexpr char kIssuer[] = "https://id.example";
inline constexpr char kAudience[] = "penumbra";

// Of somebody who is let in.
Json SoundClaims();

// Fixed, so that scripts can name their hashes.
const std::array<std::string, 2>& BearerTokens();

std::vector<Seed> TokenSeeds();

}  // namespace penumbra::fuzzing
