#include "render/scene/scene_difference.h"

#include <string>
#include <vector>

namespace penumbra {
namespace {

template <typename T>
void CompareTables(const Scene::Table<T>& from, const Scene::Table<T>& to, std::vector<T>& upserts,
                   std::vector<std::string>& removals) {
  if (&from == &to) return;
  auto before = from.begin();
  auto after = to.begin();
  while (before != from.end() || after != to.end()) {
    if (after == to.end() || (before != from.end() && before->first < after->first)) {
      removals.push_back((before++)->first);
    } else if (before == from.end() || after->first < before->first) {
      upserts.push_back(*(after++)->second);
    } else {
      const bool is_same = before->second == after->second || *before->second == *after->second;
      if (!is_same) upserts.push_back(*after->second);
      ++before;
      ++after;
    }
  }
}

}  // namespace

SceneDelta Difference(const Scene& from, const Scene& to) {
  SceneDelta delta;
  CompareTables(from.instances(), to.instances(), delta.upsert_instances, delta.remove_instances);
  CompareTables(from.lights(), to.lights(), delta.upsert_lights, delta.remove_lights);
  CompareTables(from.receivers(), to.receivers(), delta.upsert_receivers, delta.remove_receivers);
  return delta;
}

}  // namespace penumbra
