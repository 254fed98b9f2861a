// A scene on a server of its own, that one edits and many watch.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "client/session/remote_engine.h"
#include "penumbra/v1/service.grpc.pb.h"
#include "tests/load/load_client.h"
#include "tests/load/process_usage.h"
#include "tests/load/watcher.h"

namespace penumbra::testing {
class Daemon;
}

namespace penumbra::load {

// An edit of the scene.
struct TimedEdit {
  Revision revision = 0;
  std::chrono::steady_clock::time_point due;
};

struct LampDrag {
  std::vector<TimedEdit> edits;
  double seconds = 0;  // that it took
};

// From when each edit was due to the first artifact that shows it. One that has none counts until
// `deadline`, when nobody waited any longer.
std::vector<double> LatenciesMs(const std::vector<TimedEdit>& edits,
                                const std::vector<Arrival>& arrivals,
                                std::chrono::steady_clock::time_point deadline);

class SharedScene {
 public:
  static constexpr char kScene[] = "studio";

  // Starts penumbrad, makes the scene and opens the editor's session.
  // Errors  those of RemoteEngine; kUnavailable: the server does not start
  static absl::StatusOr<std::unique_ptr<SharedScene>> Start(const SceneDelta& scene);

  ~SharedScene();

  std::string address() const { return address_; }
  RemoteEngine& editor() { return *editor_; }
  ProcessUsage usage() const;
  // Errors  those of the call
  absl::StatusOr<v1::ServerStatistics> Statistics();

  // Drags the lamp `rate` times a second, on time whatever the answers take.
  // Errors  kUnavailable: not all of it was acknowledged
  absl::StatusOr<LampDrag> DragLamp(double rate, double seconds);

 private:
  SharedScene();

  std::unique_ptr<testing::Daemon> daemon_;
  std::string address_;
  std::unique_ptr<RemoteEngine> editor_;
  std::unique_ptr<v1::PenumbraService::Stub> stub_;
  std::unique_ptr<LoadClient> dragger_;  // null: nobody has dragged yet
  int drags_ = 0;
};

// The floor's shadow of the lamp, 64 samples.
ArtifactSpec WatchedSpec();

// Opens them one after another. Errors  those of Watcher::Open
absl::StatusOr<std::vector<std::unique_ptr<Watcher>>> OpenWatchers(
    const SharedScene& scene, int count, const Watcher::Options& options = {});

}  // namespace penumbra::load
