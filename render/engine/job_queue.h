// Jobs that wait for a thread: scenes and clients take turns, and what people look at comes first
// in each one's.
//
//   JobQueue jobs(pool.lane(1), accounts);
//   jobs.Add(job, {"studio", parties}, 5.0);   // job->Run() on one of the lane's threads
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "render/engine/compute_accounts.h"
#include "render/engine/fair_share.h"
#include "render/engine/party.h"
#include "render/engine/worker_pool.h"

namespace penumbra {

using Parties = std::vector<Party>;  // sorted, no two the same

// Whom a job is done for. No parties: an unnamed one of the scene.
struct JobFor {
  std::string scene_id;
  std::shared_ptr<const Parties> parties;  // null: none
};

// A thread that is free takes the job whose turn it is (fair_share.h). Jobs that only principals
// wait for who give way (ComputeAccounts) are taken while there are no others.
//
// Bounded by the jobs there are, each of which waits at most once. Any thread may use it.
class JobQueue {
 public:
  // `accounts` may be null: then all principals are alike. Both outlive it.
  JobQueue(WorkerPool::Lane& lane, ComputeAccounts* accounts) : lane_(lane), accounts_(accounts) {}

  // `estimate_ms`  what it may take; 0: nobody knows
  void Add(std::shared_ptr<QueuedJob> job, const JobFor& whom, double estimate_ms);
  // These do nothing where it does not wait.
  void Change(const QueuedJob& job, const JobFor& whom);
  void Remove(const QueuedJob& job);

  size_t waiting() const;

 private:
  struct Waiting {
    FairShare::Entry entry;
    JobFor whom;
    bool gives_way = false;
  };
  using Table = std::map<const QueuedJob*, std::unique_ptr<Waiting>>;

  void RunFirst();
  // With the lock held, as for the rest.
  std::unique_ptr<Waiting> TakeFirst();
  void Place(Waiting& waiting);
  void Displace(Waiting& waiting) { ShareOf(waiting).Remove(waiting.entry); }
  void Recall();
  bool GivesWay(const JobFor& whom);
  FairShare& ShareOf(const Waiting& waiting) { return waiting.gives_way ? rest_ : share_; }
  void Charge(const JobFor& whom, double ms) const;

  WorkerPool::Lane& lane_;
  ComputeAccounts* const accounts_;
  mutable std::mutex mutex_;
  FairShare share_;
  FairShare rest_;                // of those who give way
  std::set<std::string> giving_;  // principals who did when they were last asked about
  Table waiting_;
  uint64_t arrivals_ = 0;
  size_t posted_ = 0;  // tasks of the lane's that are going to take a job; ≥ those that wait
};

}  // namespace penumbra
