#include "tests/load/order_check.h"

#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/convert/geometry_convert.h"

namespace penumbra::load {

namespace {

using CommitsByRevision = std::map<Revision, const SentCommit*>;

void Tell(OrderFindings& findings, std::string text) {
  constexpr size_t kTold = 5;
  if (findings.errors.size() < kTold) findings.errors.push_back(std::move(text));
}

// Makes the scene again, commit by commit, and holds it against every hash that was told.
void Replay(const Scene& before, Revision head, const std::string& head_hash,
            const CommitsByRevision& by_revision, OrderFindings& findings) {
  auto scene = before.WithRevision(before.revision());
  for (Revision revision = before.revision() + 1; revision <= head; ++revision) {
    const auto commit = by_revision.find(revision);
    if (commit == by_revision.end()) {
      // It may be one that was never answered; what follows cannot be told apart then.
      ++findings.unknown;
      return Tell(findings, absl::StrCat("nobody was told of revision ", revision));
    }
    auto next = scene->Apply(commit->second->delta);
    if (!next.ok()) {
      ++findings.wrong_hash;
      return Tell(findings, std::string(next.status().message()));
    }
    scene = *std::move(next);
    if (ToProto(scene->content_hash()) != commit->second->content_hash) {
      ++findings.wrong_hash;
      Tell(findings, absl::StrCat("another content at revision ", revision));
    }
  }
  findings.wrong_hash += ToProto(scene->content_hash()) != head_hash;
}

}  // namespace

OrderFindings CheckOrder(const Scene& before, Revision head, const std::string& head_hash,
                         const std::vector<const SentCommit*>& commits) {
  OrderFindings findings;
  CommitsByRevision by_revision;
  for (const SentCommit* commit : commits) {
    if (commit->answered == Clock::time_point()) {
      ++findings.unanswered;
    } else if (!commit->error.empty()) {
      ++findings.refused;
      Tell(findings, commit->error);
    } else {
      ++findings.acknowledged;
      findings.twice += !by_revision.emplace(commit->revision, commit).second;
      findings.lost += commit->revision > head;
    }
  }
  Replay(before, head, head_hash, by_revision, findings);
  return findings;
}

}  // namespace penumbra::load
