// Turns the names in a file into ids: stable, unique, and of allowed letters only.
//
//   IdTable ids;
//   ids.Add("Oak table");  // "Oak_table"
//   ids.Add("Oak/table");  // "Oak_table-2"
#pragma once

#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

namespace penumbra {

class IdTable {
 public:
  // An id made from `name`, which may be any bytes; `fallback` where it holds no usable letter.
  std::string Add(std::string_view name, std::string_view fallback = "unnamed");

 private:
  std::unordered_set<std::string> taken_;
  std::unordered_map<std::string, int> next_suffix_;  // where the search for a free one goes on
};

}  // namespace penumbra
