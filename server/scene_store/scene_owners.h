// Who made which scene: for quotas, and kept on disk where scenes are.
//
//   owners.Open(path);                               // once, before the rest; "": memory only
//   if (auto status = owners.Take({"ana", 20}, "studio"); !status.ok()) return status;
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>

#include "absl/status/status.h"

namespace penumbra {

// A principal, and how many scenes may be theirs.
struct SceneOwner {
  std::string name;         // empty: nobody's
  uint32_t max_scenes = 0;  // 0: as many as there is room for
};

// Any thread may use it. Open and Take wait for the disk; the rest waits for neither.
class SceneOwners {
 public:
  // Errors  kDataLoss DAMAGED: what the file says cannot be read; then all scenes are nobody's.
  //         Those of ReadFileIfThere
  absl::Status Open(const std::string& path);

  // The scene is theirs from here on, on disk too.
  // Errors  kResourceExhausted QUOTA_SCENES; those of WriteDurably
  absl::Status Take(const SceneOwner& owner, const std::string& scene_id);
  // It is nobody's. That it is written down is not waited for: the next Take does it.
  void Drop(const std::string& scene_id);
  // Forgets those of other scenes.
  void KeepOnly(const std::set<std::string>& scene_ids);

  // Empty: nobody.
  std::string OwnerOf(const std::string& scene_id) const;

 private:
  // With `writing_` held, as for the next, and the other not.
  absl::Status Enter(const SceneOwner& owner, const std::string& scene_id);
  absl::Status Write() const;

  std::mutex writing_;  // held while the file is written; taken before the other
  std::string path_;    // set once, first
  mutable std::mutex mutex_;
  std::map<std::string, std::string> owners_;  // by scene
};

}  // namespace penumbra
