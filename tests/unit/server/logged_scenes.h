// Logs of scenes and the journals that they share, without a store: what becomes busy, and when, is
// for the test to say.
//
//   LoggedScenes::Make(folder, {"ada", "bob"});
//   LoggedScenes scenes(folder, options);
//   scenes.Open();
//   scenes.MakeBusy("ada");
//   scenes.CommitTogether({"ada", "bob"});   // to the journal, and to a file
//   ExpectRestored(copy, options, scenes.acknowledged(), …);
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "server/scene_store/scene_log.h"
#include "server/scene_store/shared_journal.h"

namespace penumbra::testing {

// One lamp, which each commit moves.
std::shared_ptr<const Scene> LampScene(const std::string& scene_id, Revision revision);

class LoggedScenes {
 public:
  // Empty scenes, in a folder that is made.
  static void Make(const std::string& folder, const std::vector<std::string>& ids);

  LoggedScenes(const std::string& folder, SceneLogOptions options);
  // As a server does when it starts. The others are for scenes that are open.
  absl::Status Open();

  // Commits until the scene's file names a journal.
  absl::Status MakeBusy(const std::string& id);
  // A commit to the scene's own file.
  absl::Status CommitToFile(const std::string& id);
  // `count` of each scene, written as a store does: those that name the same journal together, and
  // those that name none one to each file.
  struct Written {
    absl::Status status;
    std::set<std::string> journals;  // ids of those that have taken commits
  };
  Written CommitTogether(const std::vector<std::string>& ids, int count = 1);

  SceneLog& log(const std::string& id) { return *scenes_.at(id).log; }
  SharedJournal& journals() { return journals_; }
  // The newest revision of each scene that is on disk for sure.
  std::map<std::string, Revision> acknowledged() const;

 private:
  struct LoggedScene {
    std::unique_ptr<SceneLog> log;
    std::shared_ptr<const Scene> newest;  // that is acknowledged
  };
  struct Part {
    LoggedScene* scene = nullptr;
    std::shared_ptr<const Scene> after;
    std::vector<JournalEntry> entries;
  };

  const std::unique_ptr<DataDirectory> directory_;
  const SceneLogOptions options_;
  SharedJournal journals_;
  std::map<std::string, LoggedScene> scenes_;
};

// A server that starts on `folder` has all scenes as they were at a revision that is not before
// `acknowledged`, and at most `later` after it.
void ExpectRestored(const std::string& folder, const SceneLogOptions& options,
                    const std::map<std::string, Revision>& acknowledged, Revision later,
                    const std::string& what);

}  // namespace penumbra::testing
