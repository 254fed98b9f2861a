// The engines that the conformance tests run on: here, and through gRPC.
//
//   for (const EngineUnderTest& under_test : EnginesUnderTest()) {
//     const std::shared_ptr<Engine> engine = under_test.make();
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "render/engine/engine.h"

namespace penumbra::testing {

struct EngineUnderTest {
  std::string name;  // "Local", "Remote"
  // A new engine without scenes, which keeps alive what it needs: a server, for instance.
  std::function<std::shared_ptr<Engine>()> make;
};

std::vector<EngineUnderTest> EnginesUnderTest();

}  // namespace penumbra::testing
