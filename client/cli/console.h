// Where a command speaks: results on `out`, progress and remarks on `err`.
//
//   console.Note("the scene has no lights: …");
//   ProgressLine progress(console);
//   progress.Show("floor", 0.25);
//   progress.Finish("floor: 256x256 texels, 64 samples, 2.1 ms");
#pragma once

#include <ostream>
#include <string>
#include <string_view>

namespace penumbra {

struct Console {
  std::ostream& out;
  std::ostream& err;
  bool err_is_terminal = false;  // then progress is a bar; elsewhere it is plain lines
  bool out_is_terminal = false;  // then a table that changes is drawn in place

  void Note(std::string_view text) const;
};

// One piece of long work after another. On a terminal a bar is redrawn in place; elsewhere only the
// line of Finish is printed.
class ProgressLine {
 public:
  explicit ProgressLine(const Console& console) : console_(console) {}
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine();

  // `fraction` in [0, 1].
  void Show(std::string_view label, double fraction);
  void Finish(std::string_view line);

 private:
  void Clear();

  const Console& console_;
  bool is_drawn_ = false;
};

}  // namespace penumbra
