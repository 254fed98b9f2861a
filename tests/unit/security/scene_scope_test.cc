#include "server/security/scene_scope.h"

#include <gtest/gtest.h>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

bool Matches(const std::string& pattern, const std::string& id) {
  return SceneScope::Create({pattern}).value().Contains(id);
}

TEST(SceneScopeTest, AStarIsAnyRunOfCharacters) {
  EXPECT_TRUE(Matches("studio", "studio"));
  EXPECT_FALSE(Matches("studio", "studio2"));
  EXPECT_FALSE(Matches("studio", "Studio"));
  EXPECT_TRUE(Matches("review-*", "review-"));
  EXPECT_TRUE(Matches("review-*", "review-7"));
  EXPECT_FALSE(Matches("review-*", "a-review-7"));
  EXPECT_TRUE(Matches("*-7", "review-7-7"));
  EXPECT_TRUE(Matches("a*b*c", "abbcbc"));
  EXPECT_FALSE(Matches("a*b*c", "abbcbcd"));
  EXPECT_TRUE(Matches("*", ""));
  EXPECT_TRUE(Matches("**", "x"));
  // No other character is special.
  EXPECT_FALSE(Matches("a.c", "abc"));
}

TEST(SceneScopeTest, APatternOfStarsTakesNoTime) {
  std::string pattern;
  for (int i = 0; i < 64; ++i) pattern += "*a";
  EXPECT_FALSE(Matches(pattern, std::string(128, 'a') + "b"));
}

TEST(SceneScopeTest, SeveralPatternsAreOr) {
  const auto scope = SceneScope::Create({"studio", "review-*"}).value();
  EXPECT_TRUE(scope.Contains("studio"));
  EXPECT_TRUE(scope.Contains("review-1"));
  EXPECT_FALSE(scope.Contains("other"));
  EXPECT_FALSE(scope.is_everything());
  EXPECT_TRUE(SceneScope::Create({"studio", "*"}).value().is_everything());
}

TEST(SceneScopeTest, WhatIsNoPatternIsRefused) {
  for (const char* bad : {"", "a b", "a/b", "a?", "ü", "a\nb"}) {
    EXPECT_EQ(ErrorReason(SceneScope::Create({bad}).status()), "BAD_PATTERN") << bad;
  }
  EXPECT_EQ(ErrorReason(SceneScope::Create({std::string(129, 'a')}).status()), "BAD_PATTERN");
  EXPECT_EQ(ErrorReason(SceneScope::Create({}).status()), "BAD_PATTERN");
  EXPECT_EQ(ErrorReason(SceneScope::Create(std::vector<std::string>(65, "a")).status()),
            "BAD_PATTERN");
}

}  // namespace
}  // namespace penumbra
