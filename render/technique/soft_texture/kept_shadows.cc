#include "render/technique/soft_texture/kept_shadows.h"

#include <algorithm>
#include <thread>
#include <utility>

namespace penumbra {
namespace {

// What moves is drawn for every edit: keeping the rest pays while the rest is most of the work.
constexpr double kMostThatMoves = 0.5;

// An instance of the last scene, known by its identity; the scene may be gone.
struct KnownInstance {
  std::string id;
  std::weak_ptr<const Instance> instance;
  bool casts;

  bool Is(const std::shared_ptr<const Instance>& other) const {
    return !instance.owner_before(other) && !other.owner_before(instance);
  }
};

// Sorted by id.
using KnownInstances = std::vector<KnownInstance>;

// Kept from one computation to the next.
struct Memory {
  ShadowSubject subject;
  KnownInstances known;
  std::shared_ptr<ShadowBase> base;
};

KnownInstances KnowAll(const Scene::Table<Instance>& instances) {
  KnownInstances known;
  known.reserve(instances.size());
  for (const auto& [id, instance] : instances) known.push_back({id, instance, instance->casts});
  return known;
}

// Brings `known` up to date and tells the ids of casters that it had not, had otherwise, or has no
// more.
std::set<std::string> Update(KnownInstances& known, const Scene::Table<Instance>& instances) {
  std::set<std::string> changed;
  bool is_another_set = false;
  auto k = known.begin();
  for (auto i = instances.begin(); i != instances.end() || k != known.end();) {
    if (i == instances.end() || (k != known.end() && k->id < i->first)) {
      if (k->casts) changed.insert(k->id);
      is_another_set = true;
      ++k;
    } else if (k == known.end() || i->first < k->id) {
      if (i->second->casts) changed.insert(i->first);
      is_another_set = true;
      ++i;
    } else {
      if (!k->Is(i->second)) {
        if (k->casts || i->second->casts) changed.insert(k->id);
        k->instance = i->second;
        k->casts = i->second->casts;
      }
      ++k;
      ++i;
    }
  }
  if (is_another_set) known = KnowAll(instances);
  return changed;
}

uint64_t TrianglesOf(const Instance& instance) {
  return instance.casts ? instance.mesh->triangle_count() : 0;
}

uint64_t TrianglesOf(const Scene& scene, const std::set<std::string>& ids) {
  uint64_t count = 0;
  for (const std::string& id : ids) {
    if (const auto instance = scene.FindInstance(id)) count += TrianglesOf(*instance);
  }
  return count;
}

bool AreMostlyStill(const Scene& scene, const std::set<std::string>& moving) {
  uint64_t all = 0;
  for (const auto& [id, instance] : scene.instances()) all += TrianglesOf(*instance);
  return static_cast<double>(TrianglesOf(scene, moving)) <=
         kMostThatMoves * static_cast<double>(all);
}

std::shared_ptr<ShadowBase> NewBase(MemoryBudget& budget, const ShadowSubject& subject,
                                    std::set<std::string> moving) {
  const ReceiverPatch& receiver = subject.receiver;
  const uint32_t samples = EffectiveSampleCount(subject.light, subject.params.samples);
  const size_t texels = size_t{receiver.width} * receiver.height;
  auto lease = budget.Take(
      SampleShadows::Bytes(receiver.width, receiver.height, samples) + texels * sizeof(uint16_t) +
      BitmapCounters::Bytes(std::thread::hardware_concurrency(), receiver.width,
                            BandRows(receiver.width, receiver.height), samples));
  if (!lease) return nullptr;
  return std::make_shared<ShadowBase>(
      ShadowBase{.moving = std::move(moving),
                 .lease = *std::move(lease),
                 .shadows = SampleShadows(receiver.width, receiver.height, samples),
                 .drawn = 0,
                 .counts = std::vector<uint16_t>(texels, static_cast<uint16_t>(samples)),
                 .samples = {},
                 .counters = {},
                 .borrowing_error = {}});
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

void SampleShadows::SubtractFrom(std::vector<uint16_t>& counts, uint32_t samples) const {
  BitmapCounter counter(width_, height_, samples);
  for (uint32_t sample = 0; sample < samples; ++sample) {
    ShadowBitmap& bitmap = counter.next();
    for (uint32_t c = 0; c < columns_; ++c) {
      std::copy_n(&words_[At(sample, c, 0)], height_, bitmap.Column(c));
    }
    bitmap.Touch(0, columns_, 0, height_);
    counter.CountNext();
  }
  counter.Finish();
  counter.SubtractFrom(counts.data(), width_, 0, height_);
}

EditPlan PlanEdit(TechniqueMemory& memory, const ShadowSubject& subject, const Scene& scene) {
  auto kept = std::static_pointer_cast<Memory>(memory.kept);
  if (!kept || kept->subject != subject) {
    memory.kept = std::make_shared<Memory>(Memory{subject, KnowAll(scene.instances()), nullptr});
    return {};
  }
  std::set<std::string> moving = Update(kept->known, scene.instances());
  std::shared_ptr<ShadowBase>& base = kept->base;
  if (base &&
      !std::includes(base->moving.begin(), base->moving.end(), moving.begin(), moving.end())) {
    // Two things that are moved in turn both stay out of the base.
    std::set<std::string> both = moving;
    both.insert(base->moving.begin(), base->moving.end());
    if (AreMostlyStill(scene, both)) moving = std::move(both);
    base = nullptr;  // gives its bytes back before others are taken
  }
  if (!base && !moving.empty() && AreMostlyStill(scene, moving)) {
    base = NewBase(memory.budget, subject, std::move(moving));
  }
  if (!base) return {};
  return {.base = base, .moving_triangles = TrianglesOf(scene, base->moving)};
}

}  // namespace penumbra
