#include "server/scene_store/scene_store.h"

#include <utility>

#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"
#include "penumbra/v1/scene.pb.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"
#include "server/random_bytes.h"
#include "server/scene_store/history_reading.h"
#include "server/scene_store/scene_entry.h"

namespace penumbra {
namespace {

absl::Status Deleted(const std::string& scene_id) {
  return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
                    absl::StrCat("found '", scene_id, "', which was deleted, need a scene"));
}

absl::Status NotDeleted(const absl::Status& why) {
  return FieldError(absl::StatusCode::kUnavailable, "STORAGE_FAILED", "scene_id",
                    absl::StrCat("found a deletion that failed (", why.message(),
                                 "), need it to be deleted again"));
}

absl::Status Unknown(const std::string& scene_id) {
  return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
                    absl::StrCat("found '", scene_id, "', need the id of a scene"));
}

}  // namespace

SceneStore::SceneStore(LocalEngine& engine, BlobStore& blobs, const ServerLimits& limits,
                       ServerCounters& counters, SceneStorage* storage)
    : engine_(engine), blobs_(blobs), limits_(limits), counters_(counters), storage_(storage) {}

SceneStore::~SceneStore() = default;

std::shared_ptr<SceneStore::Entry> SceneStore::Entry::Make(std::shared_ptr<const Scene> scene,
                                                           std::shared_ptr<SceneLog> log) {
  auto entry = std::make_shared<Entry>();
  entry->incarnation = log ? log->identity().incarnation : RandomBytes(16);
  entry->log = std::move(log);
  entry->newest = std::move(scene);
  return entry;
}

void SceneStore::Restore() {
  if (!storage_) return;
  if (auto status = owners_.Open(storage_->owners_path()); !status.ok()) {
    storage_->logger().Error("owners_damaged", {{"error", std::string(status.message())}});
  }
  std::set<std::string> known;
  for (RestoredScene& restored : storage_->Restore(blobs_, limits_.scene)) {
    known.insert(restored.scene_id);
    TakeIn(std::move(restored));
  }
  owners_.KeepOnly(known);
  storage_->KeepHouse(storage_->options().refused_interval, [this] { RestoreAgain(); });
  // Blobs that nobody has used since the last time.
  storage_->KeepHouse(storage_->options().house_interval,
                      [this] { CollectBlobs(limits_.unused_blob_lifetime).IgnoreError(); });
}

void SceneStore::TakeIn(RestoredScene restored) {
  if (restored.status.ok()) restored.status = engine_.RestoreScene(restored.scene);
  if (restored.status.ok()) AttributeBlobs(*restored.scene);
  std::lock_guard lock(mutex_);
  if (!restored.status.ok()) {
    refused_[restored.scene_id] = {restored.status, restored.is_for_now()};
    return;
  }
  auto entry = Entry::Make(std::move(restored.scene), std::move(restored.log));
  for (const CommitRecord& answer : restored.answers) Remember(*entry, answer);
  entries_[restored.scene_id] = std::move(entry);
  refused_.erase(restored.scene_id);
}

void SceneStore::RestoreAgain() {
  for (const auto& [id, reason] : Refused()) {
    {
      std::lock_guard lock(mutex_);
      const auto refused = refused_.find(id);
      if (refused == refused_.end() || !refused->second.is_for_now) continue;
      if (!changing_.insert(id).second) continue;
    }
    for (RestoredScene& restored : storage_->RestoreAgain({id}, blobs_, limits_.scene)) {
      TakeIn(std::move(restored));
    }
    std::lock_guard lock(mutex_);
    changing_.erase(id);
    if (entries_.contains(id)) storage_->logger().Info("scene_is_back", {{"scene", id}});
  }
}

// Who uploaded them is not written down. What a scene needs counts for who made it.
void SceneStore::AttributeBlobs(const Scene& scene) {
  const std::string owner = owners_.OwnerOf(scene.id());
  if (owner.empty()) return;
  for (const auto& [id, instance] : scene.instances()) {
    blobs_.Attribute(instance->mesh->id(), owner);
    if (instance->alpha_mask) blobs_.Attribute(instance->alpha_mask->id(), owner);
  }
}

// Whoever creates or deletes a scene has its id to himself until that is done, on disk too.
absl::StatusOr<SceneInfo> SceneStore::Create(const std::string& scene_id, const SceneOwner& owner) {
  {
    std::lock_guard lock(mutex_);
    const auto refused = refused_.find(scene_id);
    if (refused != refused_.end() || changing_.contains(scene_id)) {
      const char* const why =
          refused == refused_.end()    ? "', which is being made or deleted, need to wait"
          : refused->second.is_for_now ? "', which cannot be read for now, need to wait"
                                       : "', whose file is damaged, need it deleted first";
      return FieldError(absl::StatusCode::kAlreadyExists, "DUPLICATE_ID", "scene_id",
                        absl::StrCat("found '", scene_id, why, " or another id"));
    }
    if (auto status = engine_.CreateScene(scene_id); !status.ok()) return status;
    changing_.insert(scene_id);
  }
  const absl::Status owned = owners_.Take(owner, scene_id);
  auto created = owned.ok() ? CreateReserved(scene_id) : absl::StatusOr<SceneInfo>(owned);
  if (!created.ok()) {
    owners_.Drop(scene_id);
    engine_.DeleteScene(scene_id).IgnoreError();
  }
  std::lock_guard lock(mutex_);
  changing_.erase(scene_id);
  return created;
}

absl::StatusOr<SceneInfo> SceneStore::CreateReserved(const std::string& scene_id) {
  std::shared_ptr<SceneLog> log;
  if (storage_) {
    auto opened = storage_->Create(scene_id);
    if (!opened.ok()) return opened.status();
    log = *std::move(opened);
  }
  const auto scene = engine_.Snapshot(scene_id);
  if (!scene.ok()) return scene.status();
  std::lock_guard lock(mutex_);
  entries_[scene_id] = Entry::Make(*scene, std::move(log));
  return InfoOf(**scene);
}

absl::Status SceneStore::Delete(const std::string& scene_id) {
  {
    std::lock_guard lock(mutex_);
    const bool is_refused = refused_.contains(scene_id);
    if (!is_refused && !entries_.contains(scene_id)) return Unknown(scene_id);
    if (!changing_.insert(scene_id).second) {
      return is_refused ? FieldError(absl::StatusCode::kUnavailable, "BUSY", "scene_id",
                                     absl::StrCat("found '", scene_id,
                                                  "', which is being read again, need to wait"))
                        : Unknown(scene_id);
    }
  }
  const absl::Status status = DeleteReserved(scene_id);
  if (status.ok()) owners_.Drop(scene_id);
  std::lock_guard lock(mutex_);
  changing_.erase(scene_id);
  return status;
}

absl::Status SceneStore::DeleteReserved(const std::string& scene_id) {
  std::shared_ptr<Entry> entry;
  {
    std::lock_guard lock(mutex_);
    const auto found = entries_.find(scene_id);
    if (found != entries_.end()) {
      entry = std::move(found->second);
      entries_.erase(found);
    }
  }
  if (!entry) return DeleteRefused(scene_id);
  std::vector<std::shared_ptr<SceneWatcher>> watchers;
  {
    std::lock_guard lock(entry->mutex);
    entry->is_deleted = true;  // what is on its way to the disk ends with kNotFound
    for (const auto& weak : entry->watchers) {
      if (auto watcher = weak.lock()) watchers.push_back(std::move(watcher));
    }
  }
  const absl::Status removed = entry->log ? storage_->Remove(*entry->log) : absl::OkStatus();
  engine_.DeleteScene(scene_id).IgnoreError();
  for (const auto& watcher : watchers) watcher->OnSceneDeleted(Deleted(scene_id));
  if (!removed.ok()) {
    // Something of it may be left on disk: nobody gets its id before that has gone too.
    std::lock_guard lock(mutex_);
    refused_[scene_id] = {.status = NotDeleted(removed)};
  }
  return removed;
}

absl::Status SceneStore::DeleteRefused(const std::string& scene_id) {
  const absl::Status status = storage_->PutAside(scene_id);
  std::lock_guard lock(mutex_);
  // Half of it may be aside: it does not come back by itself.
  Refusal& refusal = refused_[scene_id];
  if (!status.ok() && refusal.is_for_now) refusal = {.status = NotDeleted(status)};
  if (status.ok()) refused_.erase(scene_id);
  return status;
}

std::map<std::string, absl::Status> SceneStore::Refused() const {
  std::lock_guard lock(mutex_);
  std::map<std::string, absl::Status> reasons;
  for (const auto& [id, refusal] : refused_) reasons[id] = refusal.status;
  return reasons;
}

absl::StatusOr<WatchedScene> SceneStore::Watch(const std::string& scene_id,
                                               std::weak_ptr<SceneWatcher> watcher) {
  const auto entry = Find(scene_id);
  if (!entry.ok()) return entry.status();
  std::lock_guard lock((*entry)->mutex);
  if ((*entry)->is_deleted) return Deleted(scene_id);
  auto scene = engine_.Snapshot(scene_id);
  if (!scene.ok()) return scene.status();
  std::erase_if((*entry)->watchers, [](const auto& weak) { return weak.expired(); });
  (*entry)->watchers.push_back(std::move(watcher));
  return WatchedScene{*std::move(scene), (*entry)->incarnation};
}

absl::StatusOr<std::shared_ptr<const Scene>> SceneStore::SceneAt(const std::string& scene_id,
                                                                 const std::string& incarnation,
                                                                 Revision revision) {
  const auto entry = Find(scene_id);
  if (!entry.ok()) return entry.status();
  if ((*entry)->incarnation != incarnation) return Deleted(scene_id);
  auto scene = engine_.Snapshot(scene_id);
  if (!scene.ok() || (*scene)->revision() == revision) return scene;
  if (!(*entry)->log) {
    return FieldError(absl::StatusCode::kOutOfRange, "COMPACTED", "revision",
                      absl::StrCat("found ", revision, ", need ", (*scene)->revision(),
                                   ": this server keeps no history"));
  }
  return PastScene(*(*entry)->log, revision, blobs_, limits_.scene);
}

absl::StatusOr<std::shared_ptr<SceneStore::Entry>> SceneStore::Find(
    const std::string& scene_id) const {
  std::lock_guard lock(mutex_);
  if (const auto entry = entries_.find(scene_id); entry != entries_.end()) return entry->second;
  if (const auto refused = refused_.find(scene_id); refused != refused_.end()) {
    const auto& [why, is_for_now] = refused->second;
    if (is_for_now) {
      return WithRetryDelay(
          FieldError(why.code(), ErrorReason(why), "scene_id",
                     absl::StrCat("found '", scene_id, "', which cannot be read for now (",
                                  why.message(), "), need it to be later")),
          1e3 * static_cast<double>(storage_->options().refused_interval.count()));
    }
    return FieldError(absl::StatusCode::kDataLoss, "DAMAGED", "scene_id",
                      absl::StrCat("found '", scene_id, "', whose file is damaged (", why.message(),
                                   "), need a scene that is whole"));
  }
  return Unknown(scene_id.substr(0, limits_.scene.max_id_bytes));
}

absl::Status SceneStore::CollectBlobs(std::chrono::seconds age) {
  std::vector<std::shared_ptr<Entry>> entries;
  bool are_some_refused = false;
  {
    std::lock_guard lock(mutex_);
    for (const auto& [id, entry] : entries_) entries.push_back(entry);
    are_some_refused = !refused_.empty();
  }
  // What a damaged scene needs cannot be told.
  if (are_some_refused) return absl::OkStatus();
  auto unused = blobs_.DropUnused(age);
  if (!unused.ok() || unused->empty()) return unused.status();
  absl::flat_hash_set<std::string> mentioned;
  for (const auto& entry : entries) {
    if (!entry->log) continue;
    const absl::Status status = ForEachBody(*entry->log, [&](std::string_view body) {
      v1::SceneDelta delta;
      if (!delta.ParseFromArray(body.data(), static_cast<int>(body.size()))) {
        return absl::DataLossError("a delta that cannot be read");
      }
      for (const v1::Instance& instance : delta.upsert_instances()) {
        mentioned.insert(instance.mesh_hash());
        mentioned.insert(instance.alpha_mask_hash());
      }
      return absl::OkStatus();
    });
    if (!status.ok()) return status;
  }
  std::erase_if(*unused, [&](const auto& hash) { return mentioned.contains(ToProto(hash)); });
  return blobs_.RemoveFiles(*unused);
}

}  // namespace penumbra
