// Commands that keep scenes, bring them back and compare them.
#include <string>

#include "client/cli/grammar.h"
#include "client/cli/option_values.h"

namespace penumbra {
namespace {

constexpr char kExportHelp[] =
    "Writes one file with the scene, its blobs and its history at the newest revision. Edits go on "
    "meanwhile. The file is there whole or not at all.\n"
    "Try: penumbra scenes export --server 127.0.0.1:7717 studio studio.penumbra";
constexpr char kImportHelp[] =
    "Makes a scene of the file of `scenes export`, at its revision and with its history. A scene "
    "of "
    "that id must not be there. What the server has of the blobs is not sent.\n"
    "Try: penumbra scenes import --server 127.0.0.1:7717 studio.penumbra --as studio-2";
constexpr char kDiffHelp[] =
    "A and B are files of `scenes export` or ids of the server's scenes; a file goes first.\n"
    "Exit status 0: they are equal; 1: they differ; 2: they could not be compared.\n"
    "Try: penumbra scenes diff yesterday.penumbra studio --server 127.0.0.1:7717";
constexpr char kReplayHelp[] =
    "Makes every commit of the archive again, here or on a server, and holds the scene after each "
    "against the archive.\n"
    "Try: penumbra replay studio.penumbra --until 120";

}  // namespace

void Grammar::AddScenes() {
  CLI::App* scenes =
      app_.add_subcommand("scenes", "List, keep, bring back, compare and delete a server's scenes");
  scenes->require_subcommand(1);

  CLI::App* list = AddCommand(scenes_list_, "list", "List a server's scenes", scenes);
  AddEngine(list, scenes_list_.engine, true);
  list->add_flag("--json", scenes_list_.json, "Print JSON");

  CLI::App* delete_ =
      AddCommand(scenes_delete_, "delete", "Delete scenes, with all there is of them", scenes);
  delete_->add_option("ID", scenes_delete_.scene_ids, "The scenes")->required();
  AddEngine(delete_, scenes_delete_.engine, true);

  CLI::App* diff = AddCommand(scenes_diff_, "diff", "Tell what differs between two scenes", scenes);
  diff->add_option("A", scenes_diff_.from, "An archive, or a scene of the server")->required();
  diff->add_option("B", scenes_diff_.to, "Another")->required();
  AddEngine(diff, scenes_diff_.engine);
  diff->add_flag("--json", scenes_diff_.json, "Print JSON");
  diff->footer(kDiffHelp);
  AddArchives(scenes);
}

void Grammar::AddArchives(CLI::App* scenes) {
  CLI::App* write = AddCommand(scenes_export_, "export", "Write a scene to an archive", scenes);
  write->add_option("ID", scenes_export_.scene_id, "The scene")->required();
  write->add_option("FILE", scenes_export_.file, "The archive to write")->required();
  AddEngine(write, scenes_export_.engine, true);
  write->add_flag("--no-history", scenes_export_.without_history,
                  "Leave out how the scene came to be");
  write->add_flag("--json", scenes_export_.json, "Print what was written as JSON");
  write->footer(kExportHelp);

  CLI::App* read = AddCommand(scenes_import_, "import", "Make a scene of an archive", scenes);
  read->add_option("FILE", scenes_import_.file, "The archive")->required();
  Add(read, "--as", "ID", "The new scene's id (default: the archive's)",
      [this](const std::string& text) {
        return SetSceneId("--as", text, scenes_import_.scene_id);
      });
  AddEngine(read, scenes_import_.engine, true);
  read->add_flag("--json", scenes_import_.json, "Print what was made as JSON");
  read->footer(kImportHelp);

  CLI::App* replay =
      AddCommand(replay_, "replay", "Make an archive's commits again, and check each");
  replay->add_option("ARCHIVE", replay_.archive, "A file of `scenes export`")->required();
  AddEngine(replay, replay_.engine);
  Add(replay, "--scene", "ID",
      "The server's scene to make (default: one that is deleted afterwards)",
      [this](const std::string& text) { return SetSceneId("--scene", text, replay_.scene_id); })
      ->needs("--server");
  Add(replay, "--until", "REVISION", "The last revision to make (default: the archive's)",
      [this](const std::string& text) { return SetRevision("--until", text, replay_.until); });
  Add(replay, "--speed", "FACTOR", "Times as fast as it was made; 0: without waiting (default 0)",
      [this](const std::string& text) {
        return SetWithin("--speed", text, 0.0, 1e9, replay_.speed);
      });
  replay->add_flag("--json", replay_.json, "Print what was verified as JSON");
  replay->footer(kReplayHelp);
}

}  // namespace penumbra
