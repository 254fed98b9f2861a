#include "tests/accuracy/ledger.h"

#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>

#include "gtest/gtest.h"

namespace penumbra::testing {
namespace {

// Other instruction sets round otherwise: a metric may move by this much without being worse.
constexpr double kLeeway = 1.25;

struct Line {
  double kept;
  double bar;
};

std::optional<Line> FindLine(std::string_view metric) {
  std::ifstream file(PENUMBRA_LEDGER);
  for (std::string text; std::getline(file, text);) {
    std::istringstream fields(text);
    std::string name;
    Line line{};
    if (fields >> name >> line.kept >> line.bar && name == metric) return line;
  }
  return std::nullopt;
}

}  // namespace

void ExpectInLedger(std::string_view metric, double measured) {
  const auto line = FindLine(metric);
  ASSERT_TRUE(line) << metric << " measured " << measured << ", which has no line in "
                    << PENUMBRA_LEDGER;
  EXPECT_LE(measured, line->bar) << metric << ": over the bar";
  EXPECT_LE(measured, kLeeway * line->kept) << metric << ": worse than the ledger has it";
  if (kLeeway * measured < line->kept) {
    std::cout << metric << ": measured " << measured << ", the ledger has " << line->kept << "\n";
  }
}

}  // namespace penumbra::testing
