#include "client/cli/console.h"

#include <algorithm>
#include <cmath>

#include "client/cli/option_error.h"

namespace penumbra {
namespace {

constexpr int kBarCells = 30;

}  // namespace

void Console::Note(std::string_view text) const { err << "note: " << OneLine(text) << '\n'; }

ProgressLine::~ProgressLine() { Clear(); }

void ProgressLine::Show(std::string_view label, double fraction) {
  if (!console_.err_is_terminal) return;
  const int full = static_cast<int>(std::lround(std::clamp(fraction, 0.0, 1.0) * kBarCells));
  std::string bar(static_cast<size_t>(full), '#');
  bar.resize(kBarCells, '.');
  const int percent = static_cast<int>(std::floor(100.0 * std::clamp(fraction, 0.0, 1.0)));
  console_.err << "\r\x1b[K[" << bar << "] " << percent << " % " << OneLine(label) << std::flush;
  is_drawn_ = true;
}

void ProgressLine::Finish(std::string_view line) {
  Clear();
  console_.err << OneLine(line) << std::endl;
}

void ProgressLine::Clear() {
  if (is_drawn_) console_.err << "\r\x1b[K" << std::flush;
  is_drawn_ = false;
}

}  // namespace penumbra
