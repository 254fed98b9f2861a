// Numbers in effective parameters.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace penumbra {

// The shortest decimal number that reads back as the same float: 0.1, and not 0.100000001.
inline std::string FloatText(float value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
  return std::string(text.data(), end.ptr);
}

}  // namespace penumbra
