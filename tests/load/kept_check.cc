#include "tests/load/kept_check.h"

#include <algorithm>
#include <cstdio>

#include "absl/strings/str_cat.h"
#include "proto/convert/geometry_convert.h"
#include "tests/load/order_check.h"

namespace penumbra::load {
namespace {

struct Findings {
  OrderFindings order;
  size_t gone = 0;    // scenes
  size_t behind = 0;  // clients that have not heard of the newest revision
  size_t broken = 0;  // sessions

  bool is_right() const {
    return order.is_clean() && order.refused + order.unanswered + gone + behind + broken == 0;
  }
};

void Add(const OrderFindings& found, OrderFindings& sum) {
  sum.acknowledged += found.acknowledged;
  sum.refused += found.refused;
  sum.unanswered += found.unanswered;
  sum.lost += found.lost;
  sum.twice += found.twice;
  sum.unknown += found.unknown;
  sum.wrong_hash += found.wrong_hash;
  sum.errors.insert(sum.errors.end(), found.errors.begin(), found.errors.end());
}

void CheckScene(const Scene& before, const SceneInfo& now, const LoadClients& clients,
                Clock::time_point deadline, Findings& sum) {
  std::vector<const SentCommit*> commits;
  for (const auto& client : clients) {
    if (client->scene_id() != now.id) continue;
    for (const SentCommit& commit : client->commits()) commits.push_back(&commit);
    const bool is_told = client->AwaitRevision(now.revision, deadline) &&
                         client->told_hash() == ToProto(now.content_hash);
    sum.behind += !is_told;
    sum.broken += !client->status().ok();
    if (!client->status().ok()) sum.order.errors.push_back(client->status().ToString());
  }
  Add(CheckOrder(before, now.revision, ToProto(now.content_hash), commits), sum.order);
}

void Print(const Findings& sum) {
  std::printf(
      "acknowledged %zu\nrefused %zu\nunanswered %zu\nlost %zu\ntwice %zu\nunknown %zu\n"
      "wrong_hash %zu\nscenes_gone %zu\nbehind_after_2s %zu\nbroken_sessions %zu\n",
      sum.order.acknowledged, sum.order.refused, sum.order.unanswered, sum.order.lost,
      sum.order.twice, sum.order.unknown, sum.order.wrong_hash, sum.gone, sum.behind, sum.broken);
  for (size_t i = 0; i < std::min<size_t>(5, sum.order.errors.size()); ++i) {
    std::printf("error: %s\n", sum.order.errors[i].c_str());
  }
}

}  // namespace

bool HasKeptAll(const ScenesBefore& before, Engine& engine, const LoadClients& clients,
                Clock::time_point deadline) {
  const auto infos = engine.ListScenes();
  if (!infos.ok()) {
    std::printf("error: %s\n", infos.status().ToString().c_str());
    return false;
  }
  Findings sum;
  for (const auto& [id, scene] : before) {
    const auto now = std::ranges::find(*infos, id, &SceneInfo::id);
    if (now == infos->end()) {
      ++sum.gone;
      sum.order.errors.push_back(absl::StrCat("scene ", id, " is gone"));
    } else {
      CheckScene(*scene, *now, clients, deadline, sum);
    }
  }
  Print(sum);
  return sum.is_right();
}

}  // namespace penumbra::load
