#include "tests/load/kept_check.h"

#include <gtest/gtest.h>

#include "render/engine/local_engine.h"

namespace penumbra::load {
namespace {

TEST(KeptCheckTest, ASceneThatIsGoneIsNotKept) {
  LocalEngine engine{LocalEngineOptions{}};
  ScenesBefore before;
  for (const std::string id : {"load0", "load1"}) {
    ASSERT_EQ(engine.CreateScene(id), absl::OkStatus());
    before[id] = engine.Snapshot(id).value();
  }
  EXPECT_TRUE(HasKeptAll(before, engine, {}, Clock::now()));
  ASSERT_EQ(engine.DeleteScene("load1"), absl::OkStatus());
  EXPECT_FALSE(HasKeptAll(before, engine, {}, Clock::now()));
}

}  // namespace
}  // namespace penumbra::load
