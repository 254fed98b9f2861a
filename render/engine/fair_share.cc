#include "render/engine/fair_share.h"

#include <algorithm>
#include <tuple>

namespace penumbra {

class FairShare::Node {
 public:
  Node* parent = nullptr;
  double weight = 1;
  double start = 0;        // its virtual time: where its next job begins
  double clock = 0;        // that of its children: where the job taken last began
  uint64_t last_turn = 0;  // 0: it had none
  uint64_t came = 0;       // when it began to wait
  size_t waiting = 0;      // entries below
  size_t running = 0;
  std::map<std::string, std::unique_ptr<Node>, std::less<>> children;
  // That wait, in no order; of the last level.
  struct Slot {
    Entry* entry;
    size_t share;  // of the entry's
  };
  std::vector<Slot> slots;

  bool is_idle() const { return waiting + running == 0; }
};

FairShare::FairShare() : root_(std::make_unique<Node>()) {}
FairShare::~FairShare() = default;

bool FairShare::is_empty() const { return root_->waiting == 0; }

void FairShare::Add(Entry& entry, std::span<const Path> paths) {
  entry.shares.clear();
  // Nobody competes: what they have had of what nobody else wanted is forgotten.
  if (root_->is_idle()) root_->children.clear();
  ++root_->waiting;
  Link(*root_, 0, paths, 1.0, entry);
}

void FairShare::Link(Node& parent, size_t level, std::span<const Path> paths, double part,
                     Entry& entry) {
  if (level == kLevels) {
    entry.shares.back().slot = parent.slots.size();
    parent.slots.push_back({&entry, entry.shares.size() - 1});
    return;
  }
  const auto name = [&](size_t i) { return paths[i][level].name; };
  size_t groups = 1;
  for (size_t i = 1; i < paths.size(); ++i) groups += name(i) != name(i - 1);
  const double each = part / static_cast<double>(groups);
  for (size_t first = 0, last = 0; first < paths.size(); first = last) {
    while (last < paths.size() && name(last) == name(first)) ++last;
    Node& child = Enter(parent, paths[first][level]);
    entry.shares.push_back({&child, each});
    Link(child, level + 1, paths.subspan(first, last - first), each, entry);
  }
}

FairShare::Node& FairShare::Enter(Node& parent, const Step& step) {
  auto found = parent.children.find(step.name);
  if (found == parent.children.end()) {
    found = parent.children.emplace(std::string(step.name), std::make_unique<Node>()).first;
    found->second->parent = &parent;
  }
  Node& child = *found->second;
  child.weight = step.weight;
  if (child.waiting == 0) {
    child.start = std::max(child.start, parent.clock);
    child.came = ++turns_;
  }
  if (child.is_idle()) {
    child.children.clear();
    child.clock = 0;
  }
  ++child.waiting;
  return child;
}

void FairShare::Unlink(Entry& entry) {
  --root_->waiting;
  for (const Share& share : entry.shares) {
    --share.node->waiting;
    auto& slots = share.node->slots;
    if (slots.empty()) continue;
    const Node::Slot last = slots.back();
    slots[share.slot] = last;
    last.entry->shares[last.share].slot = share.slot;
    slots.pop_back();
  }
}

void FairShare::Remove(Entry& entry) {
  Unlink(entry);
  entry.shares.clear();
}

FairShare::Node& FairShare::Next(Node& parent) {
  Node* next = nullptr;
  for (auto it = parent.children.begin(); it != parent.children.end();) {
    Node& child = *it->second;
    // Where it would be if it came back.
    if (child.is_idle() && child.start <= parent.clock) {
      it = parent.children.erase(it);
      continue;
    }
    ++it;
    if (child.waiting == 0) continue;
    const auto order = [](const Node& node) {
      return std::tie(node.start, node.last_turn, node.came);
    };
    if (!next || order(child) < order(*next)) next = &child;
  }
  parent.clock = std::max(parent.clock, next->start);
  return *next;
}

FairShare::Entry* FairShare::Take() {
  if (is_empty()) return nullptr;
  Node* node = root_.get();
  for (size_t level = 0; level < kLevels; ++level) node = &Next(*node);
  Entry* first = nullptr;
  double greatest = 0;
  for (const auto& [entry, index] : node->slots) {
    const double share = entry->job->viewed_share();
    if (first && (share < greatest || (share == greatest && entry->arrival > first->arrival))) {
      continue;
    }
    first = entry;
    greatest = share;
  }
  Unlink(*first);
  ++turns_;
  ++root_->running;
  for (const Share& share : first->shares) {
    ++share.node->running;
    share.node->last_turn = turns_;
    share.node->start += first->estimate * share.part / share.node->weight;
  }
  return first;
}

void FairShare::End(Entry& entry, double cost) {
  --root_->running;
  for (const Share& share : entry.shares) {
    Node& node = *share.node;
    --node.running;
    node.start += (cost - entry.estimate) * share.part / node.weight;
    // Whoever comes now is not to begin behind it.
    if (node.waiting > 0) node.parent->clock = std::min(node.parent->clock, node.start);
  }
  entry.shares.clear();
}

}  // namespace penumbra
