#include "client/session/presence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "client/session/utf8.h"
#include "render/scene/field_error.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

struct Wrong {
  Presence presence;
  const char* field;
  const char* reason;
};

TEST(PresenceTest, WhatIsWrongIsNamed) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const View nan_eye{.camera = {.eye = {0, kNan, 0}}};
  const View flat{.camera = {}, .aspect = 0};
  const std::vector<Wrong> all = {
      {{.display_name = std::string(257, 'a')}, "presence.display_name", "LENGTH"},
      {{.display_name = "\xc3\x28"}, "presence.display_name", "MALFORMED"},
      {{.display_name = "\xe0\x80\xaf"}, "presence.display_name", "MALFORMED"},
      {{.display_name = "\xed\xa0\x80"}, "presence.display_name", "MALFORMED"},
      {{.display_name = "half \xf0\x9f\x92"}, "presence.display_name", "MALFORMED"},
      {{.colour_rgb = 0x1000000}, "presence.colour_rgb", "RANGE"},
      {{.view = nan_eye}, "presence.camera.eye", "NON_FINITE"},
      {{.view = flat}, "presence.camera.aspect", "RANGE"},
      {{.selected_ids = std::vector<std::string>(65, "a")}, "presence.selected_ids", "LENGTH"},
      {{.selected_ids = {"box", "../etc"}}, "presence.selected_ids[1]", "BAD_ID"}};
  for (const auto& [presence, field, reason] : all) {
    const absl::Status status = CheckPresence(presence);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << field;
    EXPECT_EQ(ErrorFieldPath(status), field);
    EXPECT_EQ(ErrorReason(status), reason) << field;
    EXPECT_THAT(std::string(status.message()), HasSubstr("need ")) << field;
  }
}

TEST(PresenceTest, AnyTextIsAName) {
  for (const char* name :
       {"", "Ada", "Åsa Ødegård", "山田 花子", "👩‍🎨", "\x1b[31mred\n", "\u202Eada"}) {
    EXPECT_EQ(CheckPresence({.display_name = name}), absl::OkStatus()) << name;
  }
  std::string longest;
  for (int i = 0; i < 64; ++i) longest += "👩";
  EXPECT_EQ(CheckPresence({.display_name = longest}), absl::OkStatus()) << "256 bytes";
  EXPECT_EQ(CheckPresence({.display_name = "Ada"}, {.max_display_name_bytes = 2}).code(),
            absl::StatusCode::kInvalidArgument)
      << "a server's own limit";
}

TEST(PresenceTest, EditorsHaveNames) {
  Attendance now{.own_id = "1", .others = {{"2", {.display_name = "Bob"}}, {"3", {}}}};
  EXPECT_EQ(EditorName(now), "everybody");
  EXPECT_TRUE(now.may_edit());
  now.single_editor = true;
  EXPECT_EQ(EditorName(now), "nobody");
  EXPECT_FALSE(now.may_edit());
  now.editor_id = "2";
  EXPECT_EQ(EditorName(now), "Bob");
  now.editor_id = "3";
  EXPECT_EQ(EditorName(now), "3") << "who has no name";
  now.editor_id = "1";
  EXPECT_EQ(EditorName(now), "you");
  EXPECT_TRUE(now.may_edit());
}

TEST(PresenceTest, ErrorsGetNames) {
  const Attendance now{.own_id = "1", .others = {{"27b", {.display_name = "Bob"}}, {"", {}}}};
  const auto error = FieldError(absl::StatusCode::kFailedPrecondition, "NOT_EDITOR", "commit",
                                "found 27b editing, need to be the one editor");
  const absl::Status named = WithNames(error, now);
  EXPECT_EQ(named.message(), "commit: found Bob (27b) editing, need to be the one editor");
  EXPECT_EQ(named.code(), error.code());
  EXPECT_EQ(ErrorReason(named), "NOT_EDITOR");
  EXPECT_EQ(ErrorFieldPath(named), "commit");
  EXPECT_EQ(WithNames(named, now), named) << "once";
  EXPECT_EQ(WithNames(absl::OkStatus(), now), absl::OkStatus());
  EXPECT_EQ(WithNames(absl::InternalError("27b"), now), absl::InternalError("27b"));
}

TEST(Utf8Test, CharactersOfEveryLength) {
  EXPECT_EQ(FirstUtf8("a").character, 0x61u);
  EXPECT_EQ(FirstUtf8("é").character, 0xe9u);
  EXPECT_EQ(FirstUtf8("山").character, 0x5c71u);
  EXPECT_EQ(FirstUtf8("👩x").character, 0x1f469u);
  EXPECT_EQ(FirstUtf8("👩x").bytes, 4u);
  EXPECT_EQ(FirstUtf8("\xf4\x90\x80\x80").bytes, 0u) << "past the last one";
  EXPECT_EQ(FirstUtf8("\xc0\x80").bytes, 0u);
  EXPECT_EQ(FirstUtf8("\x80").bytes, 0u);
}

}  // namespace
}  // namespace penumbra::testing
