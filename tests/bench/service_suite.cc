// The service against a plain gRPC echo: what a person waits for beyond the computation, between
// moving an object and holding the new soft shadow texture.
//
// Server and client run in this process and talk over loopback TCP. Each round moves one of 84
// boxes and waits for the final artifact (256 × 256 texels, 64 samples) of that revision; then the
// same number of bytes goes through the echo. The overhead is (latency − compute) / echo, medians
// of each: committing, scheduling, encoding, sending, decoding and the coarse pass on the way are
// in it.

#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>

#include "client/session/remote_engine.h"
#include "server/penumbra_server.h"
#include "tests/bench/bench.h"
#include "tests/bench/echo_peer.h"
#include "tests/support/shapes.h"

namespace penumbra::bench {
namespace {

constexpr uint32_t kTexels = 256;
constexpr uint32_t kSamples = 64;
constexpr float kFloorSide = 10;
constexpr int kBoxesAlong = 12;
constexpr int kBoxesAcross = 7;
constexpr size_t kLeastRounds = 20;

Instance BoxAt(int index, float lift) {
  static const auto box = testing::MeshOf(testing::UnitBoxGeometry());
  const float x = (static_cast<float>(index % kBoxesAlong) + 0.5f) / kBoxesAlong - 0.5f;
  const float z = (static_cast<float>(index / kBoxesAlong) + 0.5f) / kBoxesAcross - 0.5f;
  return {.id = "box" + std::to_string(index),
          .mesh = box,
          .world_from_mesh = testing::Placed(
              Vec3(0.9f * kFloorSide * x, 1.0f + lift, 0.9f * kFloorSide * z), 0.25f)};
}

SceneDelta Studio() {
  SceneDelta delta;
  for (int i = 0; i < kBoxesAlong * kBoxesAcross; ++i) {
    delta.upsert_instances.push_back(BoxAt(i, 0));
  }
  delta.upsert_receivers = {testing::FloorReceiver("floor", kFloorSide, kTexels)};
  delta.upsert_lights = {
      {.id = "lamp",
       .shape = RectangleLight{
           .corner = Vec3(-1, 8, -1), .edge_u = Vec3(2, 0, 0), .edge_v = Vec3(0, 0, 2)}}};
  return delta;
}

// What the callback has seen last.
class Inbox {
 public:
  void Put(const ArtifactUpdate& update, uint64_t bytes) {
    if (!update.artifact || !update.artifact->header.is_final) return;
    const double now = NowMs();
    {
      std::lock_guard lock(mutex_);
      arrival_ = {update.revision, now, update.artifact->header.timings_ms.at("compute"), bytes};
    }
    arrived_.notify_one();
  }

  struct Arrival {
    Revision revision = 0;
    double time_ms = 0;
    double compute_ms = 0;
    uint64_t bytes = 0;
  };
  Arrival Await(Revision revision) {
    std::unique_lock lock(mutex_);
    arrived_.wait(lock, [&] { return arrival_.revision >= revision; });
    return arrival_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  Arrival arrival_;
};

struct Rounds {
  std::vector<double> latency_ms, beyond_compute_ms, compute_ms, echo_ms, bytes;
};

Rounds Measure(const BenchOptions& options, RemoteEngine& engine, Inbox& inbox, EchoPeer& echo) {
  Rounds rounds;
  const double end = NowMs() + 1000 * options.min_seconds;
  for (int i = 0; NowMs() < end || rounds.latency_ms.size() < kLeastRounds; ++i) {
    SceneDelta move;
    move.upsert_instances = {
        BoxAt(i % (kBoxesAlong * kBoxesAcross), 0.5f + 0.4f * std::sin(static_cast<float>(i)))};
    const double start = NowMs();
    const auto arrival = inbox.Await(OrDie(engine.Commit("studio", move)));
    const std::string same_bytes(arrival.bytes, 'x');
    const grpc::Slice slice(same_bytes);
    rounds.latency_ms.push_back(arrival.time_ms - start);
    rounds.compute_ms.push_back(arrival.compute_ms);
    rounds.beyond_compute_ms.push_back(arrival.time_ms - start - arrival.compute_ms);
    rounds.bytes.push_back(static_cast<double>(arrival.bytes));
    rounds.echo_ms.push_back(echo.RoundTripMs(grpc::ByteBuffer(&slice, 1)));
  }
  return rounds;
}

}  // namespace

std::vector<Row> ServiceSuite(const BenchOptions& options) {
  const auto server = OrDie(PenumbraServer::Start(
      {.listen = "127.0.0.1:0", .threads = options.threads, .opens_gl = false}));
  const auto engine = OrDie(RemoteEngine::Connect({.address = server->address()}));
  if (!engine->CreateScene("studio").ok()) std::exit(EXIT_FAILURE);
  const Revision first = OrDie(engine->Commit("studio", Studio()));
  Inbox inbox;
  const ArtifactSpec spec{
      .params = SoftTextureParams{.samples = kSamples}, .light_id = "lamp", .receiver_id = "floor"};
  const auto subscription = OrDie(engine->SubscribeMeasured(
      "studio", spec, [&](const ArtifactUpdate& update, const UpdateTraffic& traffic) {
        inbox.Put(update, traffic.bytes);
      }));
  inbox.Await(first);
  EchoPeer echo;
  const Rounds measured = Measure(options, *engine, inbox, echo);
  const double beyond = Median(measured.beyond_compute_ms);
  const double echo_ms = Median(measured.echo_ms);
  const std::string prefix = "service.delta_to_artifact.";
  std::vector<Row> rows{
      {prefix + "latency_median", Median(measured.latency_ms), "ms"},
      {prefix + "latency_p99", Percentile(measured.latency_ms, 0.99), "ms"},
      {prefix + "compute_median", Median(measured.compute_ms), "ms"},
      {prefix + "beyond_compute_median", beyond, "ms"},
      {prefix + "beyond_compute_p99", Percentile(measured.beyond_compute_ms, 0.99), "ms"},
      {prefix + "update_bytes", Median(measured.bytes), "bytes"},
      {prefix + "echo_median", echo_ms, "ms"},
      {prefix + "overhead_vs_echo", beyond / echo_ms, "ratio"}};
  for (Row& row : SharedSceneRows()) rows.push_back(std::move(row));
  return rows;
}

}  // namespace penumbra::bench
