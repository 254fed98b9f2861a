// What an import leaves out, gathered as it goes.
#pragma once

#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

namespace penumbra {

class Warnings {
 public:
  // Keeps `line`, once, and no more than a person would read.
  void Add(std::string line) {
    constexpr size_t kMost = 100;
    if (lines_.size() > kMost || !seen_.insert(line).second) return;
    lines_.push_back(lines_.size() == kMost ? "… and more" : std::move(line));
  }
  const std::vector<std::string>& lines() const { return lines_; }

 private:
  std::vector<std::string> lines_;
  std::unordered_set<std::string> seen_;
};

}  // namespace penumbra
