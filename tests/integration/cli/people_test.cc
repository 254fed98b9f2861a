// People at a server's scene, by the real program: who, edit, edit-control, view --follow.
#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>

#include "tests/integration/cli/people_fixture.h"

namespace penumbra::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(PeopleTest, EditsAreUndoneAndDoneAgain) {
  const ContentHash before = Studio()->content_hash();
  const Finished edit =
      RunAt({"edit", "move box 0.5 0 -0.25", "light rect-light 1 2 3", "undo", "redo"});
  ASSERT_EQ(edit.exit_status, 0) << edit.err;
  const std::vector<Json> lines = JsonLines(edit.out);
  ASSERT_EQ(lines.size(), 4u) << edit.out;
  EXPECT_EQ(lines[0], Json::parse(R"({"line": 1, "do": "move", "revision": 2})"));
  EXPECT_EQ(lines[3], Json::parse(R"({"line": 4, "do": "redo", "revision": 5})"));
  const auto scene = Studio();
  EXPECT_EQ(scene->FindInstance("box")->world_from_mesh[3], Vec3(0.5f, 0, -0.25f));
  EXPECT_EQ(std::get<RectangleLight>(scene->FindLight("rect-light")->shape).radiance,
            Vec3(1, 2, 3));

  std::ofstream(folder_ / "script") << "# back\nmove box -0.5 0 0.25\n\nlight rect-light 5\n"
                                       "remove box\nundo\nundo\nundo\nundo\nredo\n";
  const Finished script = RunAt({"edit", "--script", folder_ / "script"});
  EXPECT_EQ(script.exit_status, 1) << "there is no fourth edit to undo";
  const Json last = JsonLines(script.out).back();
  EXPECT_EQ(last["line"], 9);
  EXPECT_EQ(last["reason"], "NOTHING_TO_UNDO");
  EXPECT_THAT(script.err, HasSubstr("penumbra: history: found no edit"));
  EXPECT_EQ(Studio()->content_hash(), scene->content_hash()) << "all of it is undone";
  EXPECT_NE(Studio()->content_hash(), before);
}

TEST_F(PeopleTest, LinesThatMakeNoSenseChangeNothing) {
  const Finished edit = RunAt({"edit", "--keep-going", "fly away", "move", "move box 1 2",
                               "move cloud 1 2 3", "light rect-light -", "camera 0 0 0 0 0 0",
                               "hand-over Nobody", "release", "move box 1 0 0"});
  EXPECT_EQ(edit.exit_status, 1);
  EXPECT_THAT(edit.err, HasSubstr("8 of 9 lines failed, the first because line: found \"fly\""));
  std::vector<std::string> reasons;
  for (const Json& line : JsonLines(edit.out)) reasons.push_back(line.value("reason", "done"));
  EXPECT_THAT(reasons, ElementsAre("UNKNOWN_COMMAND", "MISSING_FIELD", "NUMBER_COUNT", "UNKNOWN_ID",
                                   "NUMBER", "RANGE", "UNKNOWN_ID", "NOT_EDITOR", "done"));
  EXPECT_EQ(Studio()->revision(), 2u);
  EXPECT_EQ(RunAt({"edit", "--name", std::string(257, 'a'), "undo"}).exit_status, 2);
  EXPECT_THAT(RunAt({"edit", "--name", "\xff\xfe", "undo"}).err, HasSubstr("--name: found"));
  EXPECT_EQ(Run({"edit", "--server", address_, "--scene", "elsewhere", "undo"}).exit_status, 1);
  EXPECT_EQ(RunAt({"edit", "--script", folder_ / "none"}).exit_status, 2);
}

TEST_F(PeopleTest, WhoSaysWhoIsHereAndWhoHasGone) {
  const Visitor eve = Visit("Eve");
  ASSERT_TRUE(Say("Eve", eve, "camera 1 2 3 0 0 0 30", "camera"));
  ASSERT_TRUE(Say("Eve", eve, "select box rect-light", "select"));
  const pid_t watch = Start(At({"who", "--watch", "--json", "--name", "Watcher"}), "watch");
  ASSERT_TRUE(WaitForOutput("watch", "rect-light"));

  const Finished who = RunAt({"who", "--json", "--name", "Me"});
  ASSERT_EQ(who.exit_status, 0) << who.err;
  const Json all = Json::parse(who.out);
  EXPECT_EQ(all["single_editor"], false);
  ASSERT_EQ(all["participants"].size(), 2u) << "without oneself";
  const Json seen =
      all["participants"][0]["name"] == "Eve" ? all["participants"][0] : all["participants"][1];
  EXPECT_EQ(seen["camera"]["eye"], Json::parse("[1, 2, 3]"));
  EXPECT_EQ(seen["camera"]["fov_y_deg"], 30);
  EXPECT_THAT(seen["selected"].get<std::vector<std::string>>(), ElementsAre("box", "rect-light"));
  EXPECT_EQ(seen["colour"].get<std::string>().size(), 7u);
  const Finished table = RunAt({"who"});
  EXPECT_THAT(table.out, AllOf(HasSubstr(" besides you, everybody may edit\n"), HasSubstr("Eve"),
                               HasSubstr("at 1 2 3 towards 0 0 0"),
                               HasSubstr("selected box, rect-light"), Not(HasSubstr("\x1b"))));

  Kill(eve);
  EXPECT_TRUE(WaitForOutput("watch", "\"name\":\"Eve\"}]")) << "she has left";
  ASSERT_EQ(kill(watch, SIGINT), 0);
  EXPECT_EQ(Wait(watch, "watch").exit_status, 0);
}

TEST_F(PeopleTest, NamesCannotPlayTricksOnATerminal) {
  Visit("E\x1b[2Jve \u202Egnp");
  Finished who = RunAt({"who"});
  for (int i = 0; i < 100 && who.out.find("E?[2Jve ?gnp") == std::string::npos; ++i) {
    who = RunAt({"who"});
  }
  EXPECT_THAT(who.out, AllOf(HasSubstr("E?[2Jve ?gnp"), Not(HasSubstr("\x1b"))));
}

TEST_F(PeopleTest, OneEditsAtATime) {
  const Visitor eve = Visit("Eve");
  ASSERT_TRUE(Say("Eve", eve, "select", "select"));
  const Finished on = RunAt({"edit-control", "one-editor", "on"});
  EXPECT_EQ(on.exit_status, 0) << on.err;
  EXPECT_EQ(on.out, "studio: one edits at a time: nobody\n");
  Finished edit = RunAt({"edit", "move box 1 0 0"});
  EXPECT_EQ(edit.exit_status, 1);
  EXPECT_THAT(edit.err, AllOf(HasSubstr("need to take editing first"), HasSubstr("(--take")));
  edit = RunAt({"edit", "--take", "move box 1 0 0"});
  EXPECT_EQ(edit.exit_status, 0) << edit.err;

  ASSERT_TRUE(Say("Eve", eve, "move box 1 0 0", "NOT_EDITOR")) << "as it was before";
  const Finished given = RunAt({"edit-control", "hand-over", "Eve", "--json"});
  ASSERT_EQ(given.exit_status, 0) << given.err;
  EXPECT_EQ(Json::parse(given.out)["editor"], "Eve");
  ASSERT_TRUE(Say("Eve", eve, "move box 1 0 0", "\"revision\":3"));
  edit = RunAt({"edit", "move box 1 0 0"});
  EXPECT_EQ(edit.exit_status, 1);
  EXPECT_THAT(edit.err, HasSubstr("commit: found Eve ("));
  edit = RunAt({"edit", "--take", "move box 1 0 0"});
  EXPECT_THAT(edit.err, AllOf(HasSubstr("found Eve ("), HasSubstr("(--from-other)")));
  const Words push = {"push", scene_, "--floor", "--rect-light", "-1 7 -1 2 0 0 0 0 2 5"};
  EXPECT_THAT(RunAt(push).err, AllOf(HasSubstr("commit: found Eve ("), HasSubstr("--take")));
  EXPECT_EQ(RunAt({"edit-control", "one-editor", "off"}).exit_status, 1) << "Eve edits";
  edit = RunAt({"edit", "--from-other", "move box 1 0 0"});
  EXPECT_EQ(edit.exit_status, 0) << edit.err;
  ASSERT_TRUE(Say("Eve", eve, "take", "\"editor\":\"you\""));
  ASSERT_TRUE(Say("Eve", eve, "release", "everybody"));
  EXPECT_EQ(RunAt(push).exit_status, 0);
  EXPECT_THAT(RunAt({"edit-control", "hand-over", "Bob"}).err, HasSubstr("here are: Eve"));
  EXPECT_EQ(RunAt({"edit-control", "grab"}).exit_status, 2);
}

TEST_F(PeopleTest, EditingThatIsTakenIsHeldUntilTheEnd) {
  const pid_t take = Start(At({"edit-control", "take", "--name", "Ada"}), "take");
  ASSERT_TRUE(WaitForOutput("take", "one edits at a time: you"));
  EXPECT_THAT(RunAt({"edit", "move box 1 0 0"}).err, HasSubstr("found Ada ("));
  ASSERT_EQ(kill(take, SIGINT), 0);
  EXPECT_EQ(Wait(take, "take").exit_status, 0);
  EXPECT_EQ(RunAt({"edit", "move box 1 0 0"}).exit_status, 0) << "everybody may again";

  const pid_t robbed = Start(At({"edit-control", "take", "--name", "Ada"}), "robbed");
  ASSERT_TRUE(WaitForOutput("robbed", "one edits at a time: you"));
  const Visitor eve = Visit("Eve");
  ASSERT_TRUE(Say("Eve", eve, "take from-other", "\"editor\":\"you\""));
  const Finished ended = Wait(robbed, "robbed");
  EXPECT_EQ(ended.exit_status, 1);
  EXPECT_THAT(ended.err, HasSubstr("found that Eve has taken editing"));
}

TEST_F(PeopleTest, WhoeverEditsNoLongerIsTold) {
  EXPECT_THAT(RunAt({"edit-control", "hand-over", "Bob"}).err, HasSubstr("nobody else is here"));
  const Visitor ada = Visit("Ada"), eve = Visit("Eve");
  ASSERT_TRUE(Say("Ada", ada, "take", "\"editor\":\"you\""));
  ASSERT_TRUE(Say("Eve", eve, "take from-other", "\"editor\":\"you\""));
  EXPECT_TRUE(WaitForOutput("Ada", "Eve edits now, and you do not", ".err"));
}

TEST_F(PeopleTest, APictureIsSeenThroughSomebodysCamera) {
  const std::string camera = "3 4 6 0 1 0 45";
  const auto view = [&](const Words& more, const std::string& name) {
    Words words = {"view", "--size", "48x32", "--samples",
                   "4",    "--json", "--out", folder_ / (name + ".png")};
    words.insert(words.end(), more.begin(), more.end());
    return RunAt(words);
  };
  const Finished nobody = view({"--follow", "Eve", "--seconds", "0.3"}, "nobody");
  EXPECT_EQ(nobody.exit_status, 1);
  EXPECT_THAT(nobody.err,
              HasSubstr("--follow: found after 0.3 s that nobody called \"Eve\" is here, "
                        "need somebody's camera: nobody else is here"));
  const Visitor eve = Visit("Eve");
  ASSERT_TRUE(Say("Eve", eve, "camera " + camera, "camera"));
  const Finished followed = view({"--follow", "Eve"}, "followed");
  ASSERT_EQ(followed.exit_status, 0) << followed.err;
  EXPECT_EQ(Json::parse(followed.out)["camera"]["eye"], Json::parse("[3, 4, 6]"));
  ASSERT_EQ(view({"--camera", camera}, "placed").exit_status, 0);
  ASSERT_EQ(view({}, "everything").exit_status, 0);
  EXPECT_EQ(ReadText(folder_ / "followed.png"), ReadText(folder_ / "placed.png"));
  EXPECT_NE(ReadText(folder_ / "followed.png"), ReadText(folder_ / "everything.png"));
  EXPECT_EQ(view({"--follow", "Eve", "--camera", camera}, "both").exit_status, 2);
  EXPECT_EQ(view({"--floor"}, "floor").exit_status, 2);
  EXPECT_EQ(Run({"view", "--out", folder_ / "x.png"}).exit_status, 2);
}

Words Split(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

TEST_F(PeopleTest, AWatchedPictureFollowsUntilTheyLeave) {
  const Visitor eve = Visit("Eve");
  ASSERT_TRUE(Say("Eve", eve, "camera 3 4 6 0 1 0", "camera"));
  const auto start = [&](const Words& more, const std::string& name) {
    Words words = Split("view --follow Eve --watch --size 24x16 --samples 4 --json --out");
    words.push_back(folder_ / (name + ".png"));
    words.insert(words.end(), more.begin(), more.end());
    return Start(At(words), name);
  };
  std::ofstream(folder_ / "picture.png") << "before";
  std::filesystem::create_symlink("picture.png", folder_ / "holds.png");
  const pid_t holds = start({}, "holds");
  const pid_t ends = start({"--until-left"}, "ends");
  ASSERT_TRUE(WaitForOutput("holds", "[3.0,4.0,6.0]"));
  ASSERT_TRUE(WaitForOutput("ends", "[3.0,4.0,6.0]"));
  ASSERT_TRUE(Say("Eve", eve, "camera 5 4 6 0 1 0", "camera"));
  ASSERT_TRUE(WaitForOutput("holds", "[5.0,4.0,6.0]"));
  ASSERT_TRUE(Say("Eve", eve, "move box 0.5 0 0", "\"revision\":2"));
  ASSERT_TRUE(WaitForOutput("holds", "\"revision\":2"));
  Kill(eve);
  const Finished ended = Wait(ends, "ends");
  EXPECT_EQ(ended.exit_status, 0) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("note: Eve has left"));
  ASSERT_TRUE(WaitForOutput("holds", "Eve has left: the last camera stays", ".err"));
  ASSERT_EQ(RunAt({"edit", "move box 0.5 0 0"}).exit_status, 0);
  ASSERT_TRUE(WaitForOutput("holds", "\"revision\":3")) << "and goes on with the scene";
  ASSERT_EQ(kill(holds, SIGINT), 0);
  const Finished held = Wait(holds, "holds");
  EXPECT_EQ(held.exit_status, 0) << held.err;
  EXPECT_EQ(JsonLines(held.out).back()["camera"]["eye"], Json::parse("[5, 4, 6]"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "holds.png"));
  EXPECT_GT(std::filesystem::file_size(folder_ / "picture.png"), 60u);
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    EXPECT_THAT(entry.path().string(), Not(HasSubstr(".part")));
  }
}

}  // namespace
}  // namespace penumbra::testing
