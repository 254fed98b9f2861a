// penumbra replay.
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/json_text.h"
#include "client/cli/open_engine.h"
#include "client/cli/run_command.h"
#include "client/session/commit_in_parts.h"
#include "client/session/scene_archive.h"
#include "client/session/steady_clock.h"
#include "render/scene/field_error.h"
#include "render/scene/scene_difference.h"

namespace penumbra {
namespace {

// Plays an archive into a scene of an engine's, which is empty before.
class Player {
 public:
  Player(const ReplayCommand& command, Engine& engine, std::string scene_id, std::stop_token stop)
      : command_(command),
        engine_(engine),
        scene_id_(std::move(scene_id)),
        stop_(std::move(stop)) {}

  absl::StatusOr<ArchiveInfo> Play() {
    return ReadArchive(command_.archive,
                       {.on_base = [this](const auto& scene) { return PlayBase(*scene); },
                        .on_change = [this](const auto& change) { return PlayChange(change); },
                        .stop = stop_});
  }
  uint64_t verified() const { return verified_; }
  Revision revision() const { return revision_; }
  const ContentHash& content_hash() const { return content_hash_; }

 private:
  absl::Status PlayBase(const Scene& scene) {
    const SceneDelta delta = Difference(*Scene::Empty(scene.id()), scene);
    if (!delta.empty()) {
      const auto revision = CommitInParts(engine_, scene_id_, delta);
      if (!revision.ok()) return revision.status();
    }
    return Verify(scene);
  }

  absl::Status PlayChange(const ArchivedChange& change) {
    if (command_.until && change.scene->revision() > *command_.until) return absl::OkStatus();
    if (!WaitFor(change.time_ms)) return absl::CancelledError("stopped");
    // More than a commit holds it is where the server made receivers of surfaces.
    const auto revision = CommitInParts(engine_, scene_id_, change.delta);
    if (!revision.ok()) return revision.status();
    ++verified_;
    return Verify(*change.scene);
  }

  absl::Status Verify(const Scene& expected) {
    const auto scene = engine_.Snapshot(scene_id_);
    if (!scene.ok()) return scene.status();
    if ((*scene)->content_hash() != expected.content_hash()) {
      return FieldError(absl::StatusCode::kDataLoss, "HASH_MISMATCH",
                        absl::StrCat("revision ", expected.revision()),
                        absl::StrCat("found content hash ", (*scene)->content_hash().hex(),
                                     ", need ", expected.content_hash().hex()));
    }
    revision_ = expected.revision();
    content_hash_ = expected.content_hash();
    return absl::OkStatus();
  }

  // As long after the commit before as it was made, divided by the speed. False: stopped.
  bool WaitFor(int64_t time_ms) {
    // An archive may tell any times; no wait is longer than a few years.
    constexpr double kLongestMs = 1e11;
    const double since_ms =
        static_cast<double>(time_ms) - static_cast<double>(std::exchange(last_ms_, time_ms));
    if (command_.speed <= 0 || verified_ == 0 || since_ms <= 0) return !stop_.stop_requested();
    const std::chrono::duration<double, std::milli> wait(
        std::min(since_ms / command_.speed, kLongestMs));
    std::mutex mutex;
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    never.wait_for(lock, stop_, wait, [] { return false; });
    return !stop_.stop_requested();
  }

  const ReplayCommand& command_;
  Engine& engine_;
  const std::string scene_id_;
  const std::stop_token stop_;
  uint64_t verified_ = 0;
  Revision revision_ = 0;
  ContentHash content_hash_;
  int64_t last_ms_ = 0;
};

void Report(const ReplayCommand& command, const Player& player, const ArchiveInfo& info,
            double wall_ms, const Console& console) {
  if (command.json) {
    const nlohmann::ordered_json json = {{"scene", info.scene_id},
                                         {"base_revision", info.base_revision},
                                         {"revision", player.revision()},
                                         {"commits_verified", player.verified()},
                                         {"content_hash", player.content_hash().hex()},
                                         {"wall_ms", wall_ms}};
    console.out << JsonText(json) << '\n';
    return;
  }
  console.out << absl::StrFormat(
      "%d commits verified: %s from revision %d to %d, content %s, %.0f ms\n", player.verified(),
      info.scene_id, info.base_revision, player.revision(), player.content_hash().hex(), wall_ms);
}

absl::Status PlayInto(const ReplayCommand& command, Engine& engine, const std::string& scene_id,
                      const Console& console, const std::stop_token& stop) {
  const double start_ms = NowMs();
  Player player(command, engine, scene_id, stop);
  const auto info = player.Play();
  if (!info.ok()) return info.status();
  Report(command, player, *info, NowMs() - start_ms, console);
  return absl::OkStatus();
}

}  // namespace

absl::Status Run(const ReplayCommand& command, const Console& console, std::stop_token stop) {
  // All of it before anything is made: a damaged archive makes nothing.
  const auto whole = ReadArchive(command.archive, {.stop = stop});
  if (!whole.ok()) return whole.status();
  if (command.until &&
      (*command.until < whole->base_revision || *command.until > whole->revision)) {
    return FieldError(absl::StatusCode::kOutOfRange, "RANGE", "--until",
                      absl::StrCat("found ", *command.until, ", need ", whole->base_revision,
                                   " to ", whole->revision));
  }
  const auto engine = OpenEngine(command.engine);
  if (!engine.ok()) return engine.status();
  if (command.scene_id.empty()) {
    const auto scene = TemporaryScene::Create(**engine, "replay");
    if (!scene.ok()) return scene.status();
    return PlayInto(command, **engine, scene->id(), console, stop);
  }
  if (auto status = (*engine)->CreateScene(command.scene_id); !status.ok()) return status;
  const absl::Status status = PlayInto(command, **engine, command.scene_id, console, stop);
  // What was made of it is no scene of the archive.
  if (!status.ok()) (*engine)->DeleteScene(command.scene_id).IgnoreError();
  return status;
}

}  // namespace penumbra
