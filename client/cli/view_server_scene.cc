#include "client/cli/view_server_scene.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/light_option.h"
#include "client/cli/open_engine.h"
#include "client/cli/option_error.h"
#include "client/cli/people.h"
#include "client/cli/view_picture.h"
#include "client/session/camera_follower.h"
#include "client/session/steady_clock.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// For a camera to follow, where nothing is said.
constexpr double kPatienceS = 10.0;
// A scene that changed is looked at after this.
constexpr std::chrono::milliseconds kLook{50};

template <typename T>
std::vector<std::string> IdsOf(const Scene::Table<T>& table) {
  std::vector<std::string> ids;
  for (const auto& [id, object] : table) ids.push_back(id);
  return ids;
}

absl::StatusOr<ShadowPlan> PlanFor(const ViewCommand& command, const Scene& scene) {
  const ShadowRequest& request = command.request;
  ShadowPlan plan;
  plan.light_ids = IdsOf(scene.lights());
  for (const std::string& id : request.light_ids) {
    if (id != kAllLights && !scene.FindLight(id)) {
      return UnknownIdError("--light", id, plan.light_ids);
    }
  }
  const bool has_all = std::ranges::count(request.light_ids, kAllLights) > 0;
  if (!request.light_ids.empty() && !has_all) plan.light_ids = request.light_ids;
  if (InfoOf(request.params).target != SpecTarget::kReceiver) return plan;
  plan.receiver_ids = IdsOf(scene.receivers());
  if (!plan.receiver_ids.empty()) return plan;
  return absl::FailedPreconditionError(
      absl::StrCat("scene ", scene.id(), ": found no receiver, need one for ",
                   std::string(InfoOf(request.params).name),
                   ", or a --technique for all surfaces, as layered_attenuation"));
}

class SceneViewer {
 public:
  SceneViewer(const ViewCommand& command, const Console& console, std::stop_token stop)
      : command_(command), console_(console), stop_(std::move(stop)), start_ms_(NowMs()) {
    if (!command.follow.empty()) follower_.emplace(command.follow);
  }

  absl::Status Open();
  absl::Status ViewOnce();
  absl::Status Watch();

 private:
  FollowedCamera Look(const Scene& scene);
  void Note(const FollowedCamera& seen);
  absl::Status Draw(const Camera& camera);
  bool WaitForNews();
  double SecondsLeft(double of) const { return of - 1e-3 * (NowMs() - start_ms_); }

  const ViewCommand& command_;
  const Console& console_;
  const std::stop_token stop_;
  const double start_ms_;
  std::optional<CameraFollower> follower_;
  std::string noted_;  // why nobody is followed
  std::mutex mutex_;   // guards the next
  bool has_news_ = false;
  std::condition_variable_any changed_;
  Shadows shadows_;  // at a revision
  std::optional<Revision> drawn_revision_;
  std::optional<Camera> drawn_camera_;
  std::unique_ptr<Pencil> pencil_;
  // Destroyed first: no callback comes after that.
  std::unique_ptr<RemoteEngine> engine_;
  std::unique_ptr<ScenePresence> me_;
};

absl::Status SceneViewer::Open() {
  auto engine = ConnectTo(command_.engine, nullptr, &console_);
  if (!engine.ok()) return engine.status();
  engine_ = *std::move(engine);
  if (follower_) {
    auto me = EnterScene(*engine_, command_.scene_id, command_.person, [this](const auto&) {
      std::lock_guard lock(mutex_);
      has_news_ = true;
      changed_.notify_all();
    });
    if (!me.ok()) return me.status();
    me_ = *std::move(me);
  }
  auto pencil = Pencil::Create();
  if (!pencil.ok()) return pencil.status();
  pencil_ = *std::move(pencil);
  return absl::OkStatus();
}

// Without anybody to follow, as if somebody stood there.
FollowedCamera SceneViewer::Look(const Scene& scene) {
  if (follower_) return follower_->Look(me_->attendance());
  const double aspect = static_cast<double>(command_.size.width) / command_.size.height;
  const Camera camera = command_.camera ? *command_.camera
                        : drawn_camera_ ? *drawn_camera_  // which stays while objects come and go
                                        : FrameScene(scene.Bounds(), static_cast<float>(aspect));
  return {.state = FollowedCamera::State::kFollowed, .view = View{.camera = camera}};
}

void SceneViewer::Note(const FollowedCamera& seen) {
  if (std::exchange(noted_, seen.reason) == seen.reason || seen.is_followed()) return;
  console_.Note(absl::StrCat(seen.reason, seen.view ? ": the last camera stays" : ""));
}

// Whether to go on. The scene says nothing of itself when it changes, and is looked at.
bool SceneViewer::WaitForNews() {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, stop_, kLook, [this] { return has_news_; });
  has_news_ = false;
  return !stop_.stop_requested();
}

absl::Status SceneViewer::Draw(const Camera& camera) {
  auto scene = SceneOf(*engine_, command_.scene_id);
  if (!scene.ok()) return scene.status();
  const auto plan = PlanFor(command_, **scene);
  if (!plan.ok()) return plan.status();
  const bool is_traced =
      command_.final || InfoOf(command_.request.params).target == SpecTarget::kPoints;
  if (is_traced || drawn_revision_ != (*scene)->revision()) {
    shadows_.clear();
    const auto status =
        ReceiveShadows(*engine_, command_.scene_id, WantedShadows(command_, *plan, camera),
                       pencil_->room(), console_, stop_, shadows_);
    if (!status.ok()) return status;
    drawn_revision_ = (*scene)->revision();
    scene = engine_->Snapshot(command_.scene_id);
    if (!scene.ok()) return scene.status();
  }
  drawn_camera_ = camera;
  return DrawView(command_, *pencil_, camera, **scene, shadows_, console_);
}

absl::Status SceneViewer::ViewOnce() {
  const double patience_s = command_.max_seconds > 0.0 ? command_.max_seconds : kPatienceS;
  for (;;) {
    const auto scene = SceneOf(*engine_, command_.scene_id);
    if (!scene.ok()) return scene.status();
    const FollowedCamera seen = Look(**scene);
    if (seen.is_followed()) return Draw(seen.view->camera);
    if (seen.state == FollowedCamera::State::kSeveral) {
      return FieldError(absl::StatusCode::kFailedPrecondition, "AMBIGUOUS_NAME", "--follow",
                        OneLine(seen.reason));
    }
    if (SecondsLeft(patience_s) <= 0.0) {
      return FieldError(
          absl::StatusCode::kDeadlineExceeded, "NOT_HERE", "--follow",
          absl::StrFormat("found after %g s that %s, need somebody's camera: %s", patience_s,
                          seen.reason, OneLine(WhoIsHere(me_->attendance()))));
    }
    if (!WaitForNews()) return absl::CancelledError("interrupted");
  }
}

absl::Status SceneViewer::Watch() {
  do {
    const auto scene = SceneOf(*engine_, command_.scene_id);
    if (!scene.ok()) return scene.status();
    const FollowedCamera seen = Look(**scene);
    Note(seen);
    if (command_.until_left && seen.state == FollowedCamera::State::kLeft) break;
    const bool is_new = seen.view && (drawn_camera_ != seen.view->camera ||
                                      drawn_revision_ != (*scene)->revision());
    if (!is_new) continue;
    const absl::Status status = Draw(seen.view->camera);
    if (stop_.stop_requested()) break;
    if (!status.ok()) return status;
  } while ((command_.max_seconds <= 0.0 || SecondsLeft(command_.max_seconds) > 0.0) &&
           WaitForNews());
  return absl::OkStatus();
}

}  // namespace

absl::Status ViewServerScene(const ViewCommand& command, const Console& console,
                             const std::stop_token& stop) {
  SceneViewer viewer(command, console, stop);
  if (auto status = viewer.Open(); !status.ok()) return status;
  return command.watch ? viewer.Watch() : viewer.ViewOnce();
}

}  // namespace penumbra
