// Runs a fuzz target without libFuzzer, in every build: over its seeds, the inputs of its corpus,
// and so many changed versions of them, the same ones every time.
//
//   fuzz_blob --mutants 1000 tests/fuzz/corpus/blob
//   fuzz_blob crash-blob                    # one input
//   fuzz_blob --write-seeds FOLDER
//
// An input that ends the process is left as the file crash-TARGET.

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "tests/fuzz/kit/draws.h"
#include "tests/fuzz/kit/mutation.h"
#include "tests/fuzz/kit/target.h"

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv);
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);
extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned seed);
extern "C" size_t LLVMFuzzerCustomCrossOver(const uint8_t* a, size_t a_size, const uint8_t* b,
                                            size_t b_size, uint8_t* out, size_t max_size,
                                            unsigned seed);

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size) {
  static uint64_t count = 0;
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::string changed = penumbra::Mutated(text, ++count);
  changed.resize(std::min(changed.size(), max_size));
  std::copy(changed.begin(), changed.end(), data);
  return changed.size();
}

namespace penumbra::fuzzing {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxBytes = 1u << 16;
constexpr unsigned kMaxSeconds = 60;  // of one input, on a machine that does other things too

std::string target_name;
std::string running;  // the input

const uint8_t* Bytes(const std::string& text) {
  return reinterpret_cast<const uint8_t*>(text.data());
}

void KeepInput(int signal) {
  const std::string path = "crash-" + target_name;
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file >= 0 && write(file, running.data(), running.size()) >= 0) close(file);
  std::fprintf(stderr, "the input is left in %s\n", path.c_str());
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

std::string Contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Run(std::string input) {
  running = std::move(input);
  alarm(kMaxSeconds);
  LLVMFuzzerTestOneInput(Bytes(running), running.size());
}

std::string Mutant(const std::vector<std::string>& inputs, uint64_t number) {
  Draws draws(number);
  const std::string& input = inputs[number % inputs.size()];
  std::string out(kMaxBytes, '\0');
  auto* const data = reinterpret_cast<uint8_t*>(out.data());
  if (draws.OneIn(10)) {
    const std::string& other = draws.OneOf(inputs);
    out.resize(LLVMFuzzerCustomCrossOver(Bytes(input), input.size(), Bytes(other), other.size(),
                                         data, kMaxBytes, static_cast<unsigned>(draws.Bits())));
    return out;
  }
  size_t size = std::min(input.size(), kMaxBytes);
  std::copy_n(input.begin(), size, out.begin());
  // Libfuzzer piles up changes that lead to something new; here there are a few at once.
  for (uint64_t changes = 1 + draws.Below(4); changes > 0; --changes) {
    size = LLVMFuzzerCustomMutator(data, size, kMaxBytes, static_cast<unsigned>(draws.Bits()));
  }
  out.resize(size);
  return out;
}

int WriteSeeds(const fs::path& folder) {
  fs::create_directories(folder);
  for (const Seed& seed : TheTarget().Seeds()) {
    std::ofstream(folder / seed.name, std::ios::binary) << EncodeScript(seed.script);
  }
  return 0;
}

std::vector<std::string> InputsOf(const std::vector<std::string>& paths) {
  std::vector<std::string> inputs;
  for (const Seed& seed : TheTarget().Seeds()) inputs.push_back(EncodeScript(seed.script));
  std::vector<fs::path> files;
  for (const std::string& path : paths) {
    if (!fs::is_directory(path)) {
      files.emplace_back(path);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(path)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) inputs.push_back(Contents(file));
  return inputs;
}

// How often something was taken, and how often refused. Seeds are sound, so they say nothing of
// whether what is made of them gets past the door.
struct Counts {
  uint64_t accepted = 0, refused = 0;

  static Counts Now() { return {TheTarget().accepted(), TheTarget().refused()}; }
  Counts Since(const Counts& before) const {
    return {accepted - before.accepted, refused - before.refused};
  }
  bool HasShares() const {
    constexpr uint64_t kOneOf = 20;
    return std::min(accepted, refused) * kOneOf >= accepted + refused && accepted > 0;
  }
};

int Replay(uint64_t mutants, const std::vector<std::string>& paths) {
  const std::vector<std::string> inputs = InputsOf(paths);
  for (const std::string& input : inputs) Run(input);
  const Counts of_inputs = Counts::Now();
  for (uint64_t number = 0; number < mutants; ++number) Run(Mutant(inputs, number));
  alarm(0);
  const Counts of_mutants = Counts::Now().Since(of_inputs);
  std::printf("%s: %zu inputs and %llu made of them; of these %llu times accepted, %llu refused\n",
              target_name.c_str(), inputs.size(), static_cast<unsigned long long>(mutants),
              static_cast<unsigned long long>(of_mutants.accepted),
              static_cast<unsigned long long>(of_mutants.refused));
  if (mutants == 0 || of_mutants.HasShares()) return 0;
  std::fprintf(stderr, "need a twentieth accepted and a twentieth refused\n");
  return 1;
}

int Main(int argc, char** argv) {
  target_name = fs::path(argv[0]).filename();
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS, SIGILL, SIGALRM}) {
    std::signal(signal, KeepInput);
  }
  LLVMFuzzerInitialize(&argc, &argv);
  uint64_t mutants = 0;
  std::vector<std::string> paths;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--write-seeds" && i + 1 < argc) return WriteSeeds(argv[i + 1]);
    if (argument == "--mutants" && i + 1 < argc) {
      mutants = std::strtoull(argv[++i], nullptr, 10);
    } else {
      paths.push_back(argument);
    }
  }
  return Replay(mutants, paths);
}

}  // namespace
}  // namespace penumbra::fuzzing

int main(int argc, char** argv) { return penumbra::fuzzing::Main(argc, argv); }
