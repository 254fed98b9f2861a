#include "tests/fuzz/kit/script_mutator.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "google/protobuf/message.h"
#include "tests/fuzz/kit/draws.h"
#include "tests/fuzz/kit/message_mutator.h"
#include "tests/fuzz/kit/mutation.h"
#include "tests/fuzz/kit/telling_values.h"

namespace penumbra::fuzzing {
namespace {

using google::protobuf::Message;

// Long scripts hide what makes them interesting.
constexpr size_t kMostSteps = 64;

std::unique_ptr<Message> Parsed(const StepKind& kind, const std::string& payload) {
  std::unique_ptr<Message> message(kind.message->New());
  return message->ParsePartialFromString(payload) ? std::move(message) : nullptr;
}

class ScriptMutator {
 public:
  ScriptMutator(std::span<const StepKind> kinds, Script script, uint64_t seed,
                const ByteMutator& mutate_bytes)
      : kinds_(kinds), script_(std::move(script)), draws_(seed), mutate_bytes_(mutate_bytes) {}

  Script Run(size_t max_bytes) {
    if (script_.empty()) AddStep();
    if (draws_.OneIn(5)) {
      ChangeSteps();
    } else {
      ChangePayload(script_[draws_.Below(script_.size())], max_bytes);
    }
    return std::move(script_);
  }

 private:
  const StepKind& KindOf(const Step& step) const { return kinds_[step.kind % kinds_.size()]; }

  void AddStep() {
    Step step{.kind = static_cast<uint8_t>(draws_.Below(kinds_.size())), .payload = {}};
    script_.insert(script_.begin() + Place(), std::move(step));
  }

  ptrdiff_t Place() { return static_cast<ptrdiff_t>(draws_.Below(script_.size() + 1)); }

  void ChangeSteps() {
    const size_t at = draws_.Below(script_.size()), other = draws_.Below(script_.size());
    switch (draws_.Below(6)) {
      case 0:
        return AddStep();
      case 1:
      case 2: {
        Step copy = script_[at];
        script_.insert(script_.begin() + Place(), std::move(copy));
        return;
      }
      case 3:
        script_.erase(script_.begin() + static_cast<ptrdiff_t>(at));
        return;
      case 4:
        return std::swap(script_[at], script_[other]);
      default:
        script_[at].kind = static_cast<uint8_t>(draws_.Below(kinds_.size()));
    }
  }

  void ChangePayload(Step& step, size_t max_bytes) {
    const StepKind& kind = KindOf(step);
    auto message = kind.message ? Parsed(kind, step.payload) : nullptr;
    if (message && !draws_.OneIn(10)) {
      std::vector<std::unique_ptr<Message>> others;
      std::vector<const Message*> donors;
      for (const Step& other : script_) {
        if (!KindOf(other).message) continue;
        others.push_back(Parsed(KindOf(other), other.payload));
        if (others.back()) donors.push_back(others.back().get());
      }
      MessageMutator(draws_, donors).Mutate(*message);
      step.payload = message->SerializePartialAsString();
    } else if (draws_.OneIn(3)) {
      step.payload = mutate_bytes_(std::move(step.payload), max_bytes);
    } else {
      ChangeBytes(step.payload);
    }
  }

  void ChangeBytes(std::string& payload) {
    std::vector<std::string> words;
    for (const Step& other : script_) {
      if (!KindOf(other).message && other.payload.size() < 4'096) words.push_back(other.payload);
    }
    switch (draws_.Below(8)) {
      case 0:
        payload = TellingBytes(draws_, payload, words);
        return;
      case 1:
        payload.insert(draws_.Below(payload.size() + 1), TellingText(draws_, "", words));
        return;
      default:
        payload = Mutated(payload, draws_.Bits());
    }
  }

  std::span<const StepKind> kinds_;
  Script script_;
  Draws draws_;
  const ByteMutator& mutate_bytes_;
};

// Steps leave until what is left fits.
std::string Fitted(Script script, size_t max_bytes, Draws& draws) {
  while (script.size() > kMostSteps) {
    script.erase(script.begin() + static_cast<ptrdiff_t>(draws.Below(script.size())));
  }
  std::string bytes = EncodeScript(script);
  while (bytes.size() > max_bytes && script.size() > 1) {
    script.erase(script.begin() + static_cast<ptrdiff_t>(draws.Below(script.size())));
    bytes = EncodeScript(script);
  }
  if (bytes.size() > max_bytes) bytes.resize(max_bytes);
  return bytes;
}

}  // namespace

std::string MutatedScript(std::span<const StepKind> kinds, std::string_view bytes, size_t max_bytes,
                          uint64_t seed, const ByteMutator& mutate_bytes) {
  Draws draws(seed);
  ScriptMutator mutator(kinds, DecodeScript(bytes), draws.Bits(), mutate_bytes);
  return Fitted(mutator.Run(max_bytes), max_bytes, draws);
}

std::string CrossedScripts(std::string_view a, std::string_view b, size_t max_bytes,
                           uint64_t seed) {
  Draws draws(seed);
  Script script = DecodeScript(a);
  for (Step& step : DecodeScript(b)) {
    if (draws.OneIn(2)) continue;
    const auto at = static_cast<ptrdiff_t>(draws.Below(script.size() + 1));
    script.insert(script.begin() + at, std::move(step));
  }
  return Fitted(std::move(script), max_bytes, draws);
}

}  // namespace penumbra::fuzzing
