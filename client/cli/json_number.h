// Floats in JSON, which knows doubles only.
//
//   json["radius"] = JsonNumber(light.radius);   // 0.1, and not 0.10000000149011612
#pragma once

#include <charconv>
#include <string>

#include "render/math/float_text.h"

namespace penumbra {

// The double with the shortest decimal digits that read back as the same float.
inline double JsonNumber(float value) {
  const std::string text = FloatText(value);
  double number = value;  // which infinities stay
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

}  // namespace penumbra
