// penumbra scenes and penumbra replay, as the real program.
#include <gmock/gmock.h>

#include <fstream>
#include <string>

#include "client/session/remote_engine.h"
#include "tests/integration/cli/run_program.h"

namespace penumbra::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using Json = nlohmann::json;

class ScenesTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    auto server = PenumbraServer::Start(
        {.listen = "127.0.0.1:0", .opens_gl = false, .data_dir = folder_ / "data"});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    file_ = folder_ / "studio.penumbra";
  }

  Finished Scenes(std::vector<std::string> words) {
    words.insert(words.begin(), "scenes");
    words.insert(words.end(), {"--server", server_->address()});
    return Run(words);
  }
  // The scene "studio" of two commits: the lamp is moved.
  void MakeStudio() {
    for (const char* lamp : {"-1 6 -1 2 0 0 0 0 2 5", "0 6 -1 2 0 0 0 0 2 5"}) {
      ASSERT_EQ(Run({"push", scene_, "--server", server_->address(), "--scene", "studio", "--floor",
                     "--size", "32", "--rect-light", lamp})
                    .exit_status,
                0);
    }
  }
  void Export() {
    const Finished exported = Scenes({"export", "studio", file_});
    ASSERT_EQ(exported.exit_status, 0) << exported.err;
    EXPECT_THAT(exported.out, StartsWith(file_));
    EXPECT_THAT(exported.out, HasSubstr("studio at revision 2, 2 commits"));
  }

  std::string file_;
};

TEST_F(ScenesTest, NamesOfFilesNeedNotBeText) {
  MakeStudio();
  const std::string file = folder_ / "studio\xff.penumbra";
  const Finished exported = Scenes({"export", "studio", file, "--json"});
  ASSERT_EQ(exported.exit_status, 0) << exported.err;
  EXPECT_THAT(Json::parse(exported.out)["file"].get<std::string>(),
              HasSubstr("studio\xef\xbf\xbd.pen"));
  const Finished equal = Scenes({"diff", file, "studio", "--json"});
  EXPECT_EQ(equal.exit_status, 0) << equal.err;
  EXPECT_EQ(Json::parse(equal.out)["are_equal"], true);
}

TEST_F(ScenesTest, ListTellsWhatThereIs) {
  MakeStudio();
  const Finished list = Scenes({"list"});
  EXPECT_EQ(list.exit_status, 0) << list.err;
  EXPECT_THAT(list.out, AllOf(HasSubstr("SCENE"), HasSubstr("\nstudio ")));
  const Json scene = Json::parse(Scenes({"list", "--json"}).out)[0];
  EXPECT_EQ(scene["id"], "studio");
  EXPECT_EQ(scene["revision"], 2);
  EXPECT_EQ(scene["instances"], 2);
  EXPECT_EQ(scene["lights"], 1);
  EXPECT_EQ(scene["receivers"], 1);
  EXPECT_EQ(scene["clients"], 0);
  EXPECT_EQ(scene["content_hash"].get<std::string>().size(), 64u);
}

TEST_F(ScenesTest, WhatIsExportedAndDeletedIsImportedAgain) {
  MakeStudio();
  Export();
  const Json before = Json::parse(Scenes({"list", "--json"}).out)[0];
  EXPECT_THAT(Scenes({"delete", "studio"}).out, HasSubstr("deleted studio"));
  EXPECT_EQ(Json::parse(Scenes({"list", "--json"}).out).size(), 0u);
  const Finished imported = Scenes({"import", file_});
  EXPECT_EQ(imported.exit_status, 0) << imported.err;
  EXPECT_EQ(imported.out, "studio is at revision 2: 2 instances, 1 lights, 1 receivers\n");
  EXPECT_EQ(Json::parse(Scenes({"list", "--json"}).out)[0], before);
  const Finished again = Scenes({"import", file_});
  EXPECT_EQ(again.exit_status, 1);
  EXPECT_THAT(again.err, HasSubstr("found 'studio', which exists"));
  const Finished copy = Scenes({"import", file_, "--as", "copy", "--json"});
  EXPECT_EQ(copy.exit_status, 0) << copy.err;
  EXPECT_EQ(Json::parse(copy.out)["scene"], "copy");
  EXPECT_EQ(Json::parse(copy.out)["content_hash"], before["content_hash"]);
  EXPECT_EQ(Scenes({"delete", "none"}).exit_status, 1);
}

TEST_F(ScenesTest, DiffNamesObjectsAndFields) {
  MakeStudio();
  Export();
  EXPECT_EQ(Scenes({"diff", file_, "studio"}).exit_status, 0);
  EXPECT_EQ(Scenes({"diff", file_, file_}).out, "0 added, 0 removed, 0 changed\n");
  auto engine = RemoteEngine::Connect({.address = server_->address()}).value();
  const auto scene = engine->Snapshot("studio").value();
  SceneDelta delta;
  delta.upsert_instances = {*scene->FindInstance("box")};
  delta.upsert_instances[0].color = {1, 0, 0};
  delta.remove_instances = {"wall"};
  delta.upsert_lights = {{.id = "bulb", .shape = PointLight{.position = {0, 3, 0}}}};
  ASSERT_TRUE(engine->Commit("studio", delta).ok());
  const Finished diff = Scenes({"diff", file_, "studio"});
  EXPECT_EQ(diff.exit_status, 1);
  EXPECT_EQ(diff.err, "");
  EXPECT_THAT(diff.out, AllOf(HasSubstr("~ instance box\n    color: ("), HasSubstr(" -> (1"),
                              HasSubstr("- instance wall\n"), HasSubstr("+ light bulb\n"),
                              HasSubstr("1 added, 1 removed, 1 changed\n")));
  EXPECT_THAT(diff.out, Not(HasSubstr("floor")));
  const Finished json = Scenes({"diff", "studio", file_, "--json"});
  EXPECT_EQ(json.exit_status, 1);
  const Json differences = Json::parse(json.out);
  EXPECT_EQ(differences["are_equal"], false);
  EXPECT_EQ(differences["added"][0]["id"], "wall");
  EXPECT_EQ(differences["removed"][0]["id"], "bulb");
  EXPECT_EQ(differences["changed"][0]["fields"][0]["field"], "color");
  const Finished trouble = Scenes({"diff", file_, "none"});
  EXPECT_EQ(trouble.exit_status, 2) << "as diff does";
  EXPECT_THAT(trouble.err, HasSubstr("none"));
  EXPECT_EQ(Run({"scenes", "diff", file_, "studio"}).exit_status, 2) << "no server is named";
}

TEST_F(ScenesTest, ReplayMakesEveryCommitAgain) {
  MakeStudio();
  Export();
  const Finished here = Run({"replay", file_});
  EXPECT_EQ(here.exit_status, 0) << here.err;
  EXPECT_THAT(here.out, StartsWith("2 commits verified: studio from revision 0 to 2, content "));
  EXPECT_THAT(Run({"replay", file_, "--until", "1"}).out, StartsWith("1 commits verified"));
  EXPECT_EQ(Run({"replay", file_, "--until", "3"}).exit_status, 1);
  const std::vector<std::string> there = {"replay",  file_,      "--server", server_->address(),
                                          "--scene", "replayed", "--json"};
  const Finished made = Run(there);
  EXPECT_EQ(made.exit_status, 0) << made.err;
  EXPECT_EQ(Json::parse(made.out)["commits_verified"], 2);
  EXPECT_EQ(Scenes({"diff", "studio", "replayed"}).exit_status, 0);
  EXPECT_EQ(Run(there).exit_status, 1) << "it is there";
  EXPECT_EQ(Run({"replay", file_, "--server", server_->address()}).exit_status, 0);
  EXPECT_EQ(Json::parse(Scenes({"list", "--json"}).out).size(), 2u) << "nothing else is left";
  // What the archive leaves out, its base has.
  ASSERT_EQ(Scenes({"export", "studio", file_, "--no-history"}).exit_status, 0);
  EXPECT_THAT(Run({"replay", file_}).out, StartsWith("0 commits verified: studio from revision 2"));
}

TEST_F(ScenesTest, ADamagedArchiveIsToldOnOneLineWithItsPlace) {
  MakeStudio();
  Export();
  std::string bytes = ReadText(file_);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  std::ofstream(file_, std::ios::binary) << bytes;
  for (const auto& finished : {Scenes({"import", file_, "--as", "copy"}), Run({"replay", file_})}) {
    EXPECT_EQ(finished.exit_status, 1);
    EXPECT_THAT(finished.err, AllOf(StartsWith("penumbra: " + file_ + ": byte "),
                                    HasSubstr("record"), HasSubstr("seal")));
    EXPECT_EQ(std::count(finished.err.begin(), finished.err.end(), '\n'), 1);
  }
  EXPECT_EQ(Json::parse(Scenes({"list", "--json"}).out).size(), 1u);
  EXPECT_EQ(Run({"replay", scene_}).exit_status, 1) << "an OBJ file is no archive";
}

TEST_F(ScenesTest, HelpIsOfTheCommandAskedFor) {
  EXPECT_THAT(Run({"scenes", "--help"}).out, AllOf(HasSubstr("export"), HasSubstr("import")));
  EXPECT_THAT(Run({"scenes", "export", "--help"}).out,
              AllOf(HasSubstr("--no-history"), HasSubstr("Try: penumbra scenes export")));
  EXPECT_THAT(Run({"replay", "--help"}).out, HasSubstr("--until"));
  EXPECT_EQ(Run({"scenes"}).exit_status, 2);
  EXPECT_EQ(Run({"scenes", "export", "studio"}).exit_status, 2);
}

}  // namespace
}  // namespace penumbra::testing
