#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/cli/open_engine.h"
#include "render/engine/local_engine.h"

namespace penumbra {
namespace {

// E06: nobody guesses the scene that a command makes for itself.
TEST(TemporarySceneTest, E06ItsIdHas128RandomBits) {
  LocalEngine engine({.cpu_threads = 1});
  const auto first = TemporaryScene::Create(engine, "bake");
  const auto second = TemporaryScene::Create(engine, "bake");
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_THAT(first->id(), ::testing::MatchesRegex("bake-[0-9a-f]{32}"));
  EXPECT_NE(first->id(), second->id());
}

}  // namespace
}  // namespace penumbra
