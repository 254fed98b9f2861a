// The SHA-256 by which meshes, masks and scene states are named.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace penumbra {

struct ContentHash {
  std::array<uint8_t, 32> bytes{};

  auto operator<=>(const ContentHash&) const = default;

  // 64 lower-case hexadecimal digits.
  std::string hex() const;
  // The hash written as 64 hexadecimal digits; nullopt for anything else.
  static std::optional<ContentHash> FromHex(std::string_view text);

  template <typename H>
  friend H AbslHashValue(H state, const ContentHash& hash) {
    return H::combine(std::move(state), hash.bytes);
  }
};

ContentHash Sha256(std::span<const std::byte> bytes);

// The hash of a set whose members' hashes are combined one by one, in any order: adding a member
// twice takes it out again, which is how a commit updates a scene's hash without visiting the rest.
ContentHash Combine(const ContentHash& set, const ContentHash& member);

}  // namespace penumbra
