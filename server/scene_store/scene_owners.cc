#include "server/scene_store/scene_owners.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "nlohmann/json.hpp"
#include "render/scene/field_error.h"
#include "server/storage/durable_file.h"

namespace penumbra {
namespace {

using Json = nlohmann::json;

absl::Status Damaged(const std::string& path) {
  return FieldError(absl::StatusCode::kDataLoss, "DAMAGED", "owners",
                    absl::StrCat("found no table of scenes' owners in ", path, ", need one"));
}

}  // namespace

absl::Status SceneOwners::Open(const std::string& path) {
  std::lock_guard lock(mutex_);
  path_ = path;
  if (path.empty()) return absl::OkStatus();
  const auto text = ReadFileIfThere(path);
  if (!text.ok() || text->empty()) return text.status();
  const Json table = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!table.is_object()) return Damaged(path);
  for (const auto& [scene_id, owner] : table.items()) {
    if (!owner.is_string()) return Damaged(path);
    owners_[scene_id] = owner.get<std::string>();
  }
  return absl::OkStatus();
}

absl::Status SceneOwners::Take(const SceneOwner& owner, const std::string& scene_id) {
  if (owner.name.empty()) return absl::OkStatus();
  std::lock_guard writing(writing_);
  if (auto status = Enter(owner, scene_id); !status.ok()) return status;
  const absl::Status written = Write();
  if (!written.ok()) Drop(scene_id);
  return written;
}

absl::Status SceneOwners::Enter(const SceneOwner& owner, const std::string& scene_id) {
  std::lock_guard lock(mutex_);
  const auto count = std::count_if(owners_.begin(), owners_.end(),
                                   [&](const auto& row) { return row.second == owner.name; });
  if (owner.max_scenes > 0 && count >= owner.max_scenes) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_SCENES", "scene_id",
                      absl::StrCat("found ", count, " scenes of the same owner, need fewer than ",
                                   owner.max_scenes, " before another"));
  }
  owners_[scene_id] = owner.name;
  return absl::OkStatus();
}

void SceneOwners::Drop(const std::string& scene_id) {
  std::lock_guard lock(mutex_);
  owners_.erase(scene_id);
}

void SceneOwners::KeepOnly(const std::set<std::string>& scene_ids) {
  std::lock_guard lock(mutex_);
  std::erase_if(owners_, [&](const auto& row) { return !scene_ids.contains(row.first); });
}

std::string SceneOwners::OwnerOf(const std::string& scene_id) const {
  std::lock_guard lock(mutex_);
  const auto found = owners_.find(scene_id);
  return found == owners_.end() ? std::string() : found->second;
}

absl::Status SceneOwners::Write() const {
  if (path_.empty()) return absl::OkStatus();
  Json table;
  {
    std::lock_guard lock(mutex_);
    table = owners_;
  }
  // Names come from outside: bytes that are no text are written as what stands for them.
  return WriteDurably(path_, table.dump(1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace penumbra
