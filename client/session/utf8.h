// Text as people send it: characters of UTF-8, and where it is none.
//
//   while (!text.empty()) {
//     const Utf8Character next = FirstUtf8(text);
//     text.remove_prefix(std::max<size_t>(next.bytes, 1));
//   }
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace penumbra {

struct Utf8Character {
  uint32_t character = 0;
  size_t bytes = 0;  // that it takes; 0: the text does not begin with a character
};

// What `text`, which is not empty, begins with. Longer forms than needed, halves of surrogate pairs
// and what lies past U+10FFFF are no characters.
Utf8Character FirstUtf8(std::string_view text);

// Whether `text` is characters from end to end.
bool IsUtf8(std::string_view text);

}  // namespace penumbra
