// Text in parts.
#pragma once

#include <string_view>
#include <vector>

namespace penumbra {

// What lies between any of `separators`, empty parts included: one more than there are separators.
std::vector<std::string_view> Split(std::string_view text, std::string_view separators);
// The parts that are not empty.
std::vector<std::string_view> SplitWords(std::string_view text, std::string_view separators);

}  // namespace penumbra
