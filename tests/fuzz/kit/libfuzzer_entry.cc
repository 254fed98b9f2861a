// What libFuzzer calls of a program, and replay_main.cc in its place: the target's inputs are
// scripts, and are changed as such.

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "google/protobuf/stubs/logging.h"
#include "tests/fuzz/kit/script_mutator.h"
#include "tests/fuzz/kit/target.h"

// The changes that libFuzzer knows, by what its runs have learned.
extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

namespace penumbra::fuzzing {
namespace {

std::string ByLibFuzzer(std::string bytes, size_t max_bytes) {
  const size_t size = std::min(bytes.size(), max_bytes);
  bytes.resize(max_bytes);
  bytes.resize(LLVMFuzzerMutate(reinterpret_cast<uint8_t*>(bytes.data()), size, max_bytes));
  return bytes;
}

std::string_view TextOf(const uint8_t* data, size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

size_t Put(const std::string& bytes, uint8_t* out) {
  std::copy(bytes.begin(), bytes.end(), out);
  return bytes.size();
}

}  // namespace
}  // namespace penumbra::fuzzing

using namespace penumbra::fuzzing;

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  // It would report every text that is not UTF-8.
  google::protobuf::SetLogHandler(nullptr);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  TheTarget().Run(DecodeScript(TextOf(data, size)));
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned seed) {
  return Put(MutatedScript(TheTarget().kinds(), TextOf(data, size), max_size, seed, ByLibFuzzer),
             data);
}

extern "C" size_t LLVMFuzzerCustomCrossOver(const uint8_t* a, size_t a_size, const uint8_t* b,
                                            size_t b_size, uint8_t* out, size_t max_size,
                                            unsigned seed) {
  return Put(CrossedScripts(TextOf(a, a_size), TextOf(b, b_size), max_size, seed), out);
}
