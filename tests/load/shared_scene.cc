#include "tests/load/shared_scene.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <thread>
#include <utility>

#include "proto/convert/status_convert.h"
#include "tests/load/own_channel.h"
#include "tests/support/daemon.h"

namespace penumbra::load {
namespace {

// Round and round over the middle of the scene, never twice at one place.
AreaLight LampAt(double seconds, int drag) {
  const auto x = static_cast<float>(2 * std::sin(seconds) + 0.01 * drag),
             z = static_cast<float>(std::cos(seconds));
  return {.id = "lamp",
          .shape = RectangleLight{
              .corner = Vec3(x - 1, 8, z - 1), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 0, 2)}};
}

}  // namespace

SharedScene::SharedScene()
    : daemon_(
          std::make_unique<testing::Daemon>(std::vector<std::string>{"--listen", "127.0.0.1:0"})),
      address_(daemon_->Address()) {}

SharedScene::~SharedScene() = default;

ProcessUsage SharedScene::usage() const { return UsageOf(daemon_->pid()); }

absl::StatusOr<std::unique_ptr<SharedScene>> SharedScene::Start(const SceneDelta& scene) {
  std::unique_ptr<SharedScene> shared(new SharedScene());
  if (shared->address_.empty()) return absl::UnavailableError("penumbrad does not start");
  auto editor = RemoteEngine::Connect({.address = shared->address_});
  if (!editor.ok()) return editor.status();
  shared->editor_ = *std::move(editor);
  shared->stub_ = v1::PenumbraService::NewStub(OwnChannel(shared->address_));
  if (auto status = shared->editor_->CreateScene(kScene); !status.ok()) return status;
  if (auto revision = shared->editor_->Commit(kScene, scene); !revision.ok()) {
    return revision.status();
  }
  return shared;
}

absl::StatusOr<v1::ServerStatistics> SharedScene::Statistics() {
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  const grpc::Status status = stub_->GetServerInfo(&context, v1::GetServerInfoRequest(), &info);
  if (!status.ok()) return FromGrpcStatus(status);
  return info.statistics();
}

absl::StatusOr<LampDrag> SharedScene::DragLamp(double rate, double seconds) {
  if (!dragger_) {
    dragger_ = std::make_unique<LoadClient>(address_, kScene, Instance{});
    if (auto status = dragger_->Open(); !status.ok()) return status;
  }
  const size_t before = dragger_->commits().size();
  const auto count = static_cast<int>(rate * seconds);
  const auto start = Clock::now();
  const auto due_at = [&](int i) {
    return start +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(i / rate));
  };
  ++drags_;
  for (int i = 0; i < count; ++i) {
    std::this_thread::sleep_until(due_at(i));
    dragger_->Commit(due_at(i), {.upsert_lights = {LampAt(i / rate, drags_)}});
  }
  const auto end = std::max(Clock::now(), due_at(count));
  constexpr std::chrono::seconds kPatience{10};
  if (!dragger_->AwaitAnswers(Clock::now() + kPatience)) {
    return absl::UnavailableError("found edits without an answer");
  }
  LampDrag drag{.seconds = std::chrono::duration<double>(end - start).count()};
  for (const SentCommit& commit : std::span(dragger_->commits()).subspan(before)) {
    if (commit.revision == 0) return absl::UnavailableError(commit.error);
    drag.edits.push_back({.revision = commit.revision, .due = commit.due});
  }
  return drag;
}

std::vector<double> LatenciesMs(const std::vector<TimedEdit>& edits,
                                const std::vector<Arrival>& arrivals, Clock::time_point deadline) {
  std::vector<double> latencies_ms;
  auto arrival = arrivals.begin();
  for (const TimedEdit& edit : edits) {
    while (arrival != arrivals.end() && (arrival->revision < edit.revision || !arrival->is_new)) {
      ++arrival;
    }
    const auto seen = arrival == arrivals.end() ? deadline : arrival->time;
    latencies_ms.push_back(std::chrono::duration<double, std::milli>(seen - edit.due).count());
  }
  return latencies_ms;
}

ArtifactSpec WatchedSpec() {
  return {.params = SoftTextureParams{.samples = 64}, .light_id = "lamp", .receiver_id = "floor"};
}

absl::StatusOr<std::vector<std::unique_ptr<Watcher>>> OpenWatchers(
    const SharedScene& scene, int count, const Watcher::Options& options) {
  std::vector<std::unique_ptr<Watcher>> watchers;
  for (int i = 0; i < count; ++i) {
    watchers.push_back(
        std::make_unique<Watcher>(scene.address(), SharedScene::kScene, WatchedSpec(), options));
    if (auto status = watchers.back()->Open(); !status.ok()) return status;
  }
  return watchers;
}

}  // namespace penumbra::load
