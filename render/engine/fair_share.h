// Whose turn it is, where parties share threads by weight and nobody knows what a job takes before
// it has ended.
//
//   FairShare::Entry entry{.job = job, .estimate = 5.0};
//   share.Add(entry, paths);                 // each of a scene, a principal, a viewer
//   FairShare::Entry* next = share.Take();   // of whoever has had least for its weight
//   share.End(*next, 4.2);                   // what it took
//
// Parties are a tree: scenes share the threads, a scene's principals its part, a principal's
// viewers theirs. Of one viewer's jobs that of the greatest viewed_share() runs first, as it is at
// that moment, and of equals the one that came first.
//
// Each node has a virtual time: what it has had, divided by its weight. Who has had least is next.
// Who comes back starts no earlier than those who wait are by then, so that idling earns nothing. A
// job counts by its estimate when it starts and by what it took once that is known; one that
// several parties want counts for each by its part, and runs when the first of them has its turn.
//
// Source  start-time fair queueing: Goyal, Vin and Cheng 1996; departs: costs are corrected at the
//         end, after which the clock may step back to whom it was wrong about.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

// What waits in it.
class QueuedJob {
 public:
  virtual ~QueuedJob() = default;
  // May change at any time, on any thread.
  virtual double viewed_share() const = 0;
  // Runs, and returns what that took, milliseconds.
  virtual double Run() = 0;
};

// One thread at a time.
class FairShare {
 public:
  struct Step {
    std::string_view name;
    double weight = 1;  // against the others of the same parent; > 0
  };
  // From the outermost.
  static constexpr size_t kLevels = 3;
  using Path = std::array<Step, kLevels>;

  class Node;
  struct Share {
    Node* node;
    double part;      // of a job's cost, in (0, 1]
    size_t slot = 0;  // of the node's list, where it has one
  };
  struct Entry {
    std::shared_ptr<QueuedJob> job;
    double estimate = 0;   // milliseconds, ≥ 0
    uint64_t arrival = 0;  // less: came earlier

    std::vector<Share> shares{};  // FairShare's own
  };

  FairShare();
  ~FairShare();
  FairShare(const FairShare&) = delete;
  FairShare& operator=(const FairShare&) = delete;

  // `entry` stays where it is, and waits until it is taken or removed. `paths`, one at least, are
  // sorted by their names, and no two are the same.
  void Add(Entry& entry, std::span<const Path> paths);
  void Remove(Entry& entry);
  // Null where none waits. It runs from here on, until End.
  Entry* Take();
  // `cost` in milliseconds.
  void End(Entry& entry, double cost);

  bool is_empty() const;

 private:
  void Link(Node& parent, size_t level, std::span<const Path> paths, double part, Entry& entry);
  Node& Enter(Node& parent, const Step& step);
  static Node& Next(Node& parent);
  void Unlink(Entry& entry);

  const std::unique_ptr<Node> root_;
  uint64_t turns_ = 0;  // taken, and begun to be waited for
};

}  // namespace penumbra
