#include "tests/load/order_check.h"

#include <map>

#include "absl/strings/str_cat.h"
#include "proto/convert/geometry_convert.h"

namespace penumbra::load {

OrderFindings CheckOrder(const Scene& before, Revision head, const std::string& head_hash,
                         const std::vector<const SentCommit*>& commits) {
  constexpr size_t kTold = 5;
  OrderFindings findings;
  const auto tell = [&](std::string text) {
    if (findings.errors.size() < kTold) findings.errors.push_back(std::move(text));
  };
  std::map<Revision, const SentCommit*> by_revision;
  for (const SentCommit* commit : commits) {
    if (commit->answered == Clock::time_point()) {
      ++findings.unanswered;
    } else if (!commit->error.empty()) {
      ++findings.refused;
      tell(commit->error);
    } else {
      ++findings.acknowledged;
      findings.twice += !by_revision.emplace(commit->revision, commit).second;
      findings.lost += commit->revision > head;
    }
  }
  auto scene = before.WithRevision(before.revision());
  for (Revision revision = before.revision() + 1; revision <= head; ++revision) {
    const auto commit = by_revision.find(revision);
    if (commit == by_revision.end()) {
      // It may be one that was never answered; what follows cannot be told apart then.
      ++findings.unknown;
      tell(absl::StrCat("nobody was told of revision ", revision));
      return findings;
    }
    auto next = scene->Apply(commit->second->delta);
    if (!next.ok()) {
      ++findings.wrong_hash;
      tell(std::string(next.status().message()));
      return findings;
    }
    scene = *std::move(next);
    if (ToProto(scene->content_hash()) != commit->second->content_hash) {
      ++findings.wrong_hash;
      tell(absl::StrCat("another content at revision ", revision));
    }
  }
  findings.wrong_hash += ToProto(scene->content_hash()) != head_hash;
  return findings;
}

}  // namespace penumbra::load
