#include "client/cli/numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(ParseNumbersTest, CommasAndBlanksSeparate) {
  for (const char* text :
       {"1 -2.5 3e-2", "1,-2.5,3e-2", "1, -2.5,\t3e-2 ", "  1 ,-2.5   3e-2", "+1 -2.5 0.03"}) {
    const auto numbers = ParseNumbers("--x", text);
    ASSERT_TRUE(numbers.ok()) << text << ": " << numbers.status();
    EXPECT_THAT(*numbers, ElementsAre(1.0f, -2.5f, 0.03f)) << text;
  }
}

TEST(ParseNumbersTest, NothingIsNoNumbers) {
  EXPECT_THAT(*ParseNumbers("--x", ""), IsEmpty());
  EXPECT_THAT(*ParseNumbers("--x", "  "), IsEmpty());
}

TEST(ParseNumbersTest, TellsWhichOneIsNone) {
  for (const char* text : {"1 2 x", "1,2,", "1,,2", ",1", "1 nan", "1 inf", "1 -inf", "1 1e99",
                           "1 2x", "1 0x10", "1 +-2", "1;2", "1 ½"}) {
    const auto numbers = ParseNumbers("--camera", text);
    ASSERT_FALSE(numbers.ok()) << text;
    EXPECT_EQ(numbers.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(ErrorFieldPath(numbers.status()), "--camera");
    EXPECT_THAT(std::string(numbers.status().message()), HasSubstr("need a")) << text;
  }
  EXPECT_THAT(std::string(ParseNumbers("--x", "1 2 x").status().message()),
              HasSubstr("found \"x\" as number 3"));
}

TEST(ParseNumbersTest, WhatIsQuotedStaysShortAndOnOneLine) {
  const std::string text = "a\x1b[31m\n" + std::string(500, 'b');
  const std::string message(ParseNumbers("--x", text).status().message());
  EXPECT_LT(message.size(), 160u);
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_EQ(message.find('\x1b'), std::string::npos);
}

TEST(ParseSizeTest, SquareAndOblong) {
  EXPECT_EQ(*ParseSize("--size", "256x128", 1000), (GridSize{256, 128}));
  EXPECT_EQ(*ParseSize("--size", "256X128", 1000), (GridSize{256, 128}));
  EXPECT_EQ(*ParseSize("--size", "256,128", 1000), (GridSize{256, 128}));
  EXPECT_EQ(*ParseSize("--size", "256 128", 1000), (GridSize{256, 128}));
  EXPECT_EQ(*ParseSize("--size", "77", 1000), (GridSize{77, 77}));
  EXPECT_EQ(*ParseSize("--size", "1000x1", 1000), (GridSize{1000, 1}));
}

TEST(ParseSizeTest, EachSideHasARange) {
  for (const char* text :
       {"0x4", "4x0", "1001x4", "4x1001", "x4", "4x", "", "-4x4", "4x4x4", "4.5", "99999999999"}) {
    const auto size = ParseSize("--size", text, 1000);
    ASSERT_FALSE(size.ok()) << text;
    EXPECT_THAT(std::string(size.status().message()), HasSubstr("--size: found")) << text;
    EXPECT_THAT(std::string(size.status().message()), HasSubstr("from 1 to 1000")) << text;
  }
}

}  // namespace
}  // namespace penumbra
