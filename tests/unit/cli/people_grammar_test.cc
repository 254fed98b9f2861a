#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/cli/command_line.h"
#include "client/cli/people.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Words = std::vector<std::string>;

template <typename C>
C Parsed(const Words& words) {
  const auto command = ParseCommandLine(words);
  EXPECT_TRUE(command.ok()) << command.status();
  if (!command.ok() || !std::holds_alternative<C>(*command)) {
    ADD_FAILURE() << "another command";
    return {};
  }
  return std::get<C>(*command);
}

Words At(Words words) {
  words.insert(words.begin() + 1, {"--server", "a:1", "--scene", "s"});
  return words;
}

std::string ErrorOf(const Words& words) {
  return std::string(ParseCommandLine(words).status().message());
}

TEST(PeopleGrammarTest, WhoAndEdit) {
  const auto who = Parsed<WhoCommand>(
      At({"who", "--watch", "--seconds", "2", "--json", "--name", "Åsa", "--colour", "#3366FF"}));
  EXPECT_EQ(who.scene_id, "s");
  EXPECT_TRUE(who.watch && who.json);
  EXPECT_EQ(who.max_seconds, 2.0);
  EXPECT_EQ(who.person.name, "Åsa");
  EXPECT_EQ(who.person.colour_rgb, 0x3366ffu);
  const auto edit = Parsed<EditCommand>(At({"edit", "--take", "move a -1 0 0", "undo"}));
  EXPECT_THAT(edit.lines, ElementsAre("move a -1 0 0", "undo"));
  EXPECT_TRUE(edit.person.takes_editing);
  EXPECT_FALSE(edit.person.takes_from_other);
  EXPECT_EQ(Parsed<EditCommand>(At({"edit"})).script, "-");
  EXPECT_THAT(ErrorOf(At({"edit", "undo", "--script", "x"})), HasSubstr("excludes"));
  EXPECT_THAT(ErrorOf(At({"who", "--colour", "red"})), HasSubstr("six hexadecimal digits"));
  EXPECT_THAT(ErrorOf(At({"who", "--colour", "+33445"})), HasSubstr("six hexadecimal digits"));
  EXPECT_THAT(ErrorOf(At({"who", "--seconds", "2"})), HasSubstr("--watch"));
  EXPECT_THAT(ErrorOf({"who", "--scene", "s"}), HasSubstr("--server"));
}

TEST(PeopleGrammarTest, EditControl) {
  EXPECT_EQ(Parsed<EditControlCommand>(At({"edit-control", "take"})).action, EditingAction::kTake);
  const auto given = Parsed<EditControlCommand>({"edit-control", "hand-over", "Ada L", "--server",
                                                 "a:1", "--scene", "s", "--from-other", "--json"});
  EXPECT_EQ(given.action, EditingAction::kHandOver);
  EXPECT_EQ(given.who, "Ada L");
  EXPECT_TRUE(given.person.takes_from_other && given.json);
  EXPECT_EQ(given.engine.server, "a:1");
  EXPECT_EQ(Parsed<EditControlCommand>(At({"edit-control", "one-editor", "on"})).action,
            EditingAction::kOneEditorOn);
  EXPECT_EQ(Parsed<EditControlCommand>(
                {"edit-control", "one-editor", "off", "--server", "a:1", "--scene", "s"})
                .action,
            EditingAction::kOneEditorOff);
  for (const Words& wrong :
       {Words{"edit-control"}, Words{"edit-control", "grab"}, Words{"edit-control", "hand-over"},
        Words{"edit-control", "one-editor", "maybe"}}) {
    EXPECT_NE(ErrorOf(At(wrong)), "");
  }
}

TEST(PeopleGrammarTest, AViewIsOfAFileOrOfAScene) {
  const auto view = Parsed<ViewCommand>(
      At({"view", "--follow", "Ada", "--watch", "--until-left", "--out", "x.png"}));
  EXPECT_EQ(view.scene_id, "s");
  EXPECT_EQ(view.follow, "Ada");
  EXPECT_TRUE(view.watch && view.until_left);
  for (const Words& wrong :
       {Words{"view", "a.glb"}, Words{"view", "--floor"},
        Words{"view", "--receiver", "0 0 0 1 0 0 0 0 1"}, Words{"view", "--point-light", "0 1 0 1"},
        Words{"view", "--texture-size", "8"},
        Words{"view", "--follow", "a", "--camera", "0 0 1 0 0 0"}}) {
    Words words = At(wrong);
    words.insert(words.end(), {"--out", "x.png"});
    EXPECT_THAT(ErrorOf(words), HasSubstr("excludes")) << wrong.back();
  }
  EXPECT_THAT(ErrorOf({"view", "a.glb", "--watch", "--out", "x.png"}), HasSubstr("--scene"));
  EXPECT_THAT(ErrorOf({"view", "--scene", "s", "--out", "x.png"}), HasSubstr("--server"));
}

TEST(PeopleTest, ErrorsSayWhichOptionsHelp) {
  const auto hint = [](const char* reason) {
    return std::string(
        WithTakeHint(FieldError(absl::StatusCode::kFailedPrecondition, reason, "commit", "found x"))
            .message());
  };
  EXPECT_EQ(hint("NOT_EDITOR"), "commit: found x (--take, or --take --from-other)");
  EXPECT_EQ(hint("EDITOR_PRESENT"), "commit: found x (--from-other)");
  EXPECT_EQ(hint("STALE_BASE"), "commit: found x");
}

TEST(PeopleTest, TablesAreForPeople) {
  Attendance now{
      .own_id = "1",
      .others = {{"2",
                  {.display_name = "Bob\x1b[1m", .colour_rgb = 0x010203, .selected_ids = {"box"}}}},
      .single_editor = true,
      .editor_id = "2",
      .is_current = true};
  const std::string plain = WhoTable("studio", now, false);
  EXPECT_THAT(plain, HasSubstr("studio: 1 besides you, one edits at a time: Bob?[1m\n"));
  EXPECT_THAT(plain, HasSubstr("#010203 Bob?[1m"));
  EXPECT_THAT(plain, HasSubstr("edits no camera, selected box\n"));
  EXPECT_THAT(WhoTable("studio", now, true), HasSubstr("\x1b[48;2;1;2;3m"));
  EXPECT_NE(PresenceOf({.name = "Ada"}).colour_rgb, PresenceOf({.name = "Bob"}).colour_rgb);
  EXPECT_EQ(PresenceOf({.name = "Ada"}).colour_rgb, PresenceOf({.name = "Ada"}).colour_rgb);
}

}  // namespace
}  // namespace penumbra
