#include "render/technique/soft_texture/kept_shadows.h"

#include <algorithm>
#include <utility>

namespace penumbra {
namespace {

using Instances = ShadowBase::Instances;

// What moves is drawn for every edit: keeping the rest pays while the rest is most of the work.
constexpr double kMostThatMoves = 0.5;

// Kept from one computation to the next.
struct Memory {
  ShadowSubject subject;
  Instances instances;  // of the last scene
  std::shared_ptr<ShadowBase> base;
};

// The ids of casters that one of the two has and the other has not, or has otherwise.
std::set<std::string> Differing(const Scene::Table<Instance>& a, const Scene::Table<Instance>& b) {
  std::set<std::string> ids;
  const auto add = [&](const auto& entry) {
    if (entry.second->casts) ids.insert(entry.first);
  };
  auto i = a.begin(), j = b.begin();
  while (i != a.end() || j != b.end()) {
    if (j == b.end() || (i != a.end() && i->first < j->first)) {
      add(*i++);
    } else if (i == a.end() || j->first < i->first) {
      add(*j++);
    } else {
      if (i->second != j->second) {
        add(*i);
        add(*j);
      }
      ++i;
      ++j;
    }
  }
  return ids;
}

bool AreMostlyStill(const Scene& scene, const std::set<std::string>& moving) {
  uint64_t all = 0, in_motion = 0;
  for (const auto& [id, instance] : scene.instances()) {
    if (!instance->casts) continue;
    all += instance->mesh->triangle_count();
    if (moving.contains(id)) in_motion += instance->mesh->triangle_count();
  }
  return static_cast<double>(in_motion) <= kMostThatMoves * static_cast<double>(all);
}

std::shared_ptr<ShadowBase> NewBase(MemoryBudget& budget, const ShadowSubject& subject,
                                    const Scene& scene, std::set<std::string> moving) {
  const ReceiverPatch& receiver = subject.receiver;
  const uint32_t samples = subject.params.samples;
  const size_t texels = size_t{receiver.width} * receiver.height;
  auto lease = budget.Take(SampleShadows::Bytes(receiver.width, receiver.height, samples) +
                           texels * sizeof(uint16_t));
  if (!lease) return nullptr;
  return std::make_shared<ShadowBase>(
      ShadowBase{.subject = subject,
                 .moving = std::move(moving),
                 .instances = scene.shared_instances(),
                 .lease = *std::move(lease),
                 .shadows = SampleShadows(receiver.width, receiver.height, samples),
                 .counts = {},
                 .samples = {}});
}

}  // namespace

void SampleShadows::Store(uint32_t sample, uint32_t first_row, const ShadowBitmap& bitmap) {
  for (uint32_t c = 0; c < bitmap.columns; ++c) {
    const uint32_t begin = bitmap.touched_rows_begin[c];
    const uint32_t end = std::min(bitmap.touched_rows_end[c], height_ - first_row);
    if (begin >= end) continue;
    std::copy(bitmap.Column(c) + begin, bitmap.Column(c) + end,
              words_.begin() + static_cast<std::ptrdiff_t>(At(sample, c, first_row + begin)));
  }
}

void SampleShadows::Subtract(uint32_t sample, uint32_t first_row, ShadowBitmap& bitmap) const {
  for (uint32_t c = 0; c < bitmap.columns; ++c) {
    const uint32_t begin = bitmap.touched_rows_begin[c];
    const uint32_t end = std::min(bitmap.touched_rows_end[c], height_ - first_row);
    uint32_t* const words = bitmap.Column(c);
    const uint32_t* const here = &words_[At(sample, c, first_row)];
    for (uint32_t row = begin; row < end; ++row) words[row] &= ~here[row];
  }
}

ShadowPlan PlanShadows(TechniqueMemory& memory, const ShadowSubject& subject, const Scene& scene) {
  const auto kept = std::static_pointer_cast<Memory>(memory.kept);
  const Instances instances = scene.shared_instances();
  const bool is_known = kept && kept->subject == subject;
  std::shared_ptr<ShadowBase> base = is_known ? kept->base : nullptr;
  std::set<std::string> moving;
  if (is_known) moving = Differing(*kept->instances, *instances);
  memory.kept = nullptr;  // if this computation comes to nothing, so does what it was to keep

  const auto now = std::make_shared<Memory>(Memory{subject, instances, nullptr});
  const auto keep = [&](std::shared_ptr<ShadowBase> next) {
    now->base = std::move(next);
    memory.kept = now;
  };
  if (base && !base->counts.empty()) {
    const std::set<std::string> changed = Differing(*base->instances, *instances);
    if (std::includes(base->moving.begin(), base->moving.end(), changed.begin(), changed.end())) {
      keep(base);
      return {.base = base, .base_is_drawn = true};
    }
    // Two things that are moved in turn both stay out of the base.
    std::set<std::string> both = moving;
    both.insert(base->moving.begin(), base->moving.end());
    if (AreMostlyStill(scene, both)) moving = std::move(both);
  }
  base = nullptr;  // gives its bytes back before others are taken
  if (is_known) kept->base = nullptr;
  std::shared_ptr<ShadowBase> next;
  if (!moving.empty() && AreMostlyStill(scene, moving)) {
    next = NewBase(memory.budget, subject, scene, std::move(moving));
  }
  keep(next);
  return {.base = next, .base_is_drawn = false};
}

}  // namespace penumbra
