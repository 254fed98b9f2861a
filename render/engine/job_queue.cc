#include "render/engine/job_queue.h"

#include <algorithm>
#include <utility>

namespace penumbra {
namespace {

// What every job counts for at least, however short, and all of them where there is no clock: then
// everybody has one after the other.
constexpr double kLeastCostMs = 0.01;

const Party kUnnamed{};

std::span<const Party> PartiesOf(const JobFor& whom) {
  if (!whom.parties || whom.parties->empty()) return {&kUnnamed, 1};
  return *whom.parties;
}

// Calls `visit` with each principal once.
template <typename Visit>
void ForEachPrincipal(const JobFor& whom, Visit visit) {
  const std::string* last = nullptr;
  for (const Party& party : PartiesOf(whom)) {
    if (!last || *last != party.principal) visit(party.principal);
    last = &party.principal;
  }
}

}  // namespace

void JobQueue::Add(std::shared_ptr<QueuedJob> job, const JobFor& whom, double estimate_ms) {
  {
    std::lock_guard lock(mutex_);
    auto& waiting = waiting_[job.get()];
    if (waiting) return;
    waiting = std::make_unique<Waiting>();
    waiting->whom = whom;
    waiting->entry.job = std::move(job);
    waiting->entry.estimate = std::max(estimate_ms, kLeastCostMs);
    waiting->entry.arrival = ++arrivals_;
    Place(*waiting);
    // Some may be left over from jobs that were removed.
    if (posted_ >= waiting_.size()) return;
    ++posted_;
  }
  lane_.Post([this] { RunFirst(); });
}

void JobQueue::Change(const QueuedJob& job, const JobFor& whom) {
  std::lock_guard lock(mutex_);
  const auto found = waiting_.find(&job);
  if (found == waiting_.end()) return;
  Displace(*found->second);
  found->second->whom = whom;
  Place(*found->second);
}

void JobQueue::Remove(const QueuedJob& job) {
  std::unique_ptr<Waiting> removed;  // dies without the lock
  std::lock_guard lock(mutex_);
  const auto found = waiting_.find(&job);
  if (found == waiting_.end()) return;
  Displace(*found->second);
  removed = std::move(found->second);
  waiting_.erase(found);
}

size_t JobQueue::waiting() const {
  std::lock_guard lock(mutex_);
  return waiting_.size();
}

void JobQueue::Place(Waiting& waiting) {
  std::vector<FairShare::Path> paths;
  for (const Party& party : PartiesOf(waiting.whom)) {
    const double weight = accounts_ ? accounts_->StandingOf(party.principal).weight : 1.0;
    paths.push_back({{{waiting.whom.scene_id}, {party.principal, weight}, {party.viewer}}});
  }
  waiting.gives_way = GivesWay(waiting.whom);
  ShareOf(waiting).Add(waiting.entry, paths);
}

bool JobQueue::GivesWay(const JobFor& whom) {
  if (!accounts_) return false;
  bool all_do = true;
  ForEachPrincipal(whom, [&](const std::string& principal) {
    const bool gives_way = accounts_->StandingOf(principal).gives_way;
    if (gives_way) giving_.insert(principal);
    all_do = all_do && gives_way;
  });
  return all_do;
}

// Those who need give way no longer.
void JobQueue::Recall() {
  const size_t before = giving_.size();
  std::erase_if(giving_, [this](const std::string& principal) {
    return !accounts_->StandingOf(principal).gives_way;
  });
  if (giving_.size() == before) return;
  for (const auto& [job, waiting] : waiting_) {
    if (!waiting->gives_way) continue;
    Displace(*waiting);
    Place(*waiting);
  }
}

std::unique_ptr<JobQueue::Waiting> JobQueue::TakeFirst() {
  if (!rest_.is_empty()) Recall();
  const auto taken = [this](FairShare::Entry* entry) {
    auto found = waiting_.extract(entry->job.get());
    return std::move(found.mapped());
  };
  while (FairShare::Entry* const entry = share_.Take()) {
    auto waiting = taken(entry);
    if (!GivesWay(waiting->whom)) return waiting;
    // It has used up its part since it came. What it has not run costs nothing.
    share_.End(waiting->entry, 0);
    Place(*waiting);
    const QueuedJob* const job = waiting->entry.job.get();
    waiting_.emplace(job, std::move(waiting));
  }
  FairShare::Entry* const entry = rest_.Take();
  return entry ? taken(entry) : nullptr;
}

void JobQueue::Charge(const JobFor& whom, double ms) const {
  if (!accounts_) return;
  int principals = 0;
  ForEachPrincipal(whom, [&](const std::string&) { ++principals; });
  ForEachPrincipal(
      whom, [&](const std::string& principal) { accounts_->Charge(principal, ms / principals); });
}

void JobQueue::RunFirst() {
  std::unique_ptr<Waiting> first;
  {
    std::lock_guard lock(mutex_);
    --posted_;
    first = TakeFirst();
  }
  if (!first) return;
  const double ms = first->entry.job->Run();
  Charge(first->whom, ms);
  std::lock_guard lock(mutex_);
  ShareOf(*first).End(first->entry, std::max(ms, kLeastCostMs));
}

}  // namespace penumbra
