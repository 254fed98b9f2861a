// One thing to be fuzzed. Each program of tests/fuzz defines TheTarget; libfuzzer_entry.cc gives it
// to libFuzzer, and replay_main.cc to the test runs of every build.
//
//   class Blobs final : public Target { … };
//   Target& TheTarget() { static Blobs target; return target; }
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tests/fuzz/kit/script.h"

namespace penumbra::fuzzing {

struct Seed {
  std::string name;
  Script script;
};

class Target {
 public:
  virtual ~Target() = default;

  // What a script consists of.
  virtual std::span<const StepKind> kinds() const = 0;
  // Ends the process (see require.h) where something does not hold.
  virtual void Run(const Script& script) = 0;
  // Sound scripts to begin with, from which all others are made.
  virtual std::vector<Seed> Seeds() = 0;

  // How often what it was fed was taken, and how often refused: a fuzzer whose inputs are all
  // refused at the door tests the door alone.
  uint64_t accepted() const { return accepted_; }
  uint64_t refused() const { return refused_; }

 protected:
  void Count(bool is_accepted) { ++(is_accepted ? accepted_ : refused_); }

 private:
  uint64_t accepted_ = 0;
  uint64_t refused_ = 0;
};

Target& TheTarget();

}  // namespace penumbra::fuzzing
