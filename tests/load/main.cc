// penumbra_load: edits scenes of a server at a fixed rate, and says how soon it answered and
// whether it kept everything. The load is open: commits are due at fixed times, however slow the
// answers are, and times count from when a commit was due. Fails when the load was not reached.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "absl/synchronization/mutex.h"
#include "client/session/remote_engine.h"
#include "tests/load/echo_load.h"
#include "tests/load/kept_check.h"
#include "tests/load/load_client.h"
#include "tests/load/load_scenes.h"
#include "tests/load/overload.h"
#include "tests/load/percentiles.h"

namespace penumbra::load {
namespace {

struct Plan {
  std::string server;
  int clients = 200;
  int scenes = 50;
  int viewers = 64;  // of the first scene, of whom one edits
  double rate = 2'000;
  double seconds = 120;
  double max_late_ms = 10;
};

int Fail(const std::string& text) {
  std::fprintf(stderr, "penumbra_load: %s\n", text.c_str());
  return EXIT_FAILURE;
}

std::string SceneOf(const Plan& plan, int client) {
  if (client < plan.viewers) return SceneId(0);
  const int others = std::max(1, plan.scenes - 1);
  return SceneId(1 + (client - plan.viewers) % others);
}

// One editor after another, spread evenly over the time.
void Drive(const Plan& plan, LoadClients& clients) {
  std::vector<LoadClient*> editors;
  for (int i = 0; i < plan.clients; ++i) {
    if (i == 0 || i >= plan.viewers) editors.push_back(clients[static_cast<size_t>(i)].get());
  }
  const auto interval =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / plan.rate));
  const auto count = static_cast<int64_t>(plan.rate * plan.seconds);
  const auto start = Clock::now() + std::chrono::milliseconds(100);
  for (int64_t i = 0; i < count; ++i) {
    const auto due = start + i * interval;
    std::this_thread::sleep_until(due);
    editors[static_cast<size_t>(i) % editors.size()]->Commit(due);
  }
}

struct Report {
  std::vector<double> answer_ms;  // from due to answered
  std::vector<double> late_ms;    // from due to sent
};

Report TimesOf(const LoadClients& clients) {
  using Ms = std::chrono::duration<double, std::milli>;
  Report report;
  for (const auto& client : clients) {
    for (const SentCommit& commit : client->commits()) {
      report.late_ms.push_back(Ms(commit.sent - commit.due).count());
      if (commit.revision > 0) report.answer_ms.push_back(Ms(commit.answered - commit.due).count());
    }
  }
  return report;
}

int Run(const Plan& plan) {
  PrintPercentiles("echo", EchoLoad(plan.clients, plan.rate, std::min(20.0, plan.seconds)));
  const auto before = MakeScenes(plan.server, plan.scenes);
  if (!before.ok()) return Fail(std::string(before.status().message()));
  LoadClients clients;
  for (int i = 0; i < plan.clients; ++i) {
    clients.push_back(std::make_unique<LoadClient>(plan.server, SceneOf(plan, i), BoxOf(i)));
    if (auto status = clients.back()->Open(); !status.ok()) return Fail(status.ToString());
  }
  Drive(plan, clients);
  const auto deadline = Clock::now() + std::chrono::seconds(2);
  for (const auto& client : clients) client->AwaitAnswers(deadline);
  auto engine = RemoteEngine::Connect({.address = plan.server});
  if (!engine.ok()) return Fail(std::string(engine.status().message()));
  const bool is_right = HasKeptAll(*before, **engine, clients, deadline);
  const Report report = TimesOf(clients);
  PrintPercentiles("answer", report.answer_ms);
  PrintPercentiles("sent_late", report.late_ms);
  if (Percentile(report.late_ms, 0.99) > plan.max_late_ms) return Fail("the load was not reached");
  return is_right ? EXIT_SUCCESS : EXIT_FAILURE;
}

int Overload(const Plan& plan, OverloadPlan overload) {
  overload.server = plan.server;
  overload.clients = plan.clients;
  overload.scenes = plan.scenes;
  overload.seconds = plan.seconds;
  const absl::Status status = RunOverload(overload);
  return status.ok() ? EXIT_SUCCESS : Fail(std::string(status.message()));
}

}  // namespace
}  // namespace penumbra::load

int main(int argc, char** argv) {
  CLI::App app{"Edits scenes of a server at a fixed rate, and checks that all of it is kept."};
  penumbra::load::Plan plan;
  app.add_option("--server", plan.server, "The server")->required();
  app.add_option("--clients", plan.clients, "Sessions")->check(CLI::Range(1, 1'000));
  app.add_option("--scenes", plan.scenes, "Scenes")->check(CLI::Range(1, 250));
  app.add_option("--viewers", plan.viewers, "Sessions of the first scene")
      ->check(CLI::Range(0, 1'000));
  app.add_option("--rate", plan.rate, "Commits a second, of all together")
      ->check(CLI::Range(1.0, 100'000.0));
  app.add_option("--seconds", plan.seconds, "For how long")->check(CLI::Range(1.0, 3'600.0));
  app.add_option("--max-late", plan.max_late_ms,
                 "How late it may send, in ms: the 99th percentile. Later it was no such load");
  bool is_overload = false;
  penumbra::load::OverloadPlan overload;
  app.add_flag("--overload", is_overload,
               "Instead: find what the server can carry, and send it more than that; --rate and "
               "--viewers have no part in it");
  app.add_option("--times", overload.times, "How much more")->check(CLI::Range(1.0, 100.0));
  app.add_flag("--deaf", overload.is_deaf, "Send although the server has said to wait");
  app.add_option("--server-pid", overload.server_pid, "Whose memory to look at");
  app.add_option("--max-memory-mb", overload.max_memory_mb, "That it may have, MiB");
  CLI11_PARSE(app, argc, argv);
  // As in penumbrad: the load's own work is not what is measured.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  return is_overload ? penumbra::load::Overload(plan, overload) : penumbra::load::Run(plan);
}
