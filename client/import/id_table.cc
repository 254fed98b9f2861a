#include "client/import/id_table.h"

#include <algorithm>

#include "absl/strings/ascii.h"

namespace penumbra {
namespace {

// Leaves room for a suffix below the 128 bytes that an id may have.
constexpr size_t kLongestStem = 112;

std::string Sanitised(std::string_view name) {
  std::string stem;
  for (const char c : name.substr(0, kLongestStem)) {
    const bool allowed =
        absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '_' || c == '-';
    stem.push_back(allowed ? c : '_');
  }
  const bool readable = std::any_of(stem.begin(), stem.end(), [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c));
  });
  return readable ? stem : std::string();
}

}  // namespace

std::string IdTable::Add(std::string_view name, std::string_view fallback) {
  std::string stem = Sanitised(name);
  if (stem.empty()) stem = fallback;
  if (taken_.insert(stem).second) return stem;
  int& suffix = next_suffix_.try_emplace(stem, 2).first->second;
  for (;; ++suffix) {
    std::string id = stem + "-" + std::to_string(suffix);
    if (taken_.insert(id).second) return id;
  }
}

}  // namespace penumbra
