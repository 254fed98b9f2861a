// A client that watches one artifact of a scene, and notes what comes and when.
//
//   Watcher watcher(address, "studio", spec);
//   if (auto status = watcher.Open(); !status.ok()) …
//   … watcher.TakeArrivals();
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "penumbra/v1/service.grpc.pb.h"
#include "render/engine/engine.h"

namespace penumbra::load {

struct Arrival {
  Revision revision = 0;
  bool is_new = false;  // an artifact, not only word that the one before still holds
  std::chrono::steady_clock::time_point time;
};

class Watcher {
 public:
  struct Options {
    bool reads = true;         // false: from the first update on it takes nothing more
    bool acknowledges = true;  // so that tiles that have not changed are left out
    // Every message of an update, on the watcher's thread; may be null.
    std::function<void(const v1::ArtifactUpdate&)> on_message = nullptr;
  };

  // On a connection of its own.
  Watcher(const std::string& address, std::string scene_id, ArtifactSpec spec, Options options);
  Watcher(const std::string& address, std::string scene_id, ArtifactSpec spec)
      : Watcher(address, std::move(scene_id), std::move(spec), Options{}) {}
  ~Watcher();

  // Returns once the first update is there.
  absl::Status Open();

  std::vector<Arrival> TakeArrivals();
  // Whether it has heard of the revision by then.
  bool AwaitRevision(Revision revision, std::chrono::steady_clock::time_point deadline);
  uint64_t received_bytes() const { return received_bytes_; }
  // Why the server ended the session; ok while it has not.
  absl::Status status() const;

 private:
  void Read();
  void Take(const v1::ArtifactUpdate& update);

  const std::string scene_id_;
  const ArtifactSpec spec_;
  const Options options_;
  std::unique_ptr<v1::PenumbraService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::SessionRequest, v1::SessionResponse>> stream_;
  std::atomic<uint64_t> received_bytes_ = 0;
  std::atomic<bool> is_closing_ = false;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool has_update_ = false;
  bool has_ended_ = false;
  Revision newest_ = 0;
  bool has_artifact_ = false;  // in the update under way
  std::vector<Arrival> arrivals_;
  absl::Status status_;
  std::thread reader_;
};

}  // namespace penumbra::load
