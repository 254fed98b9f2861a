#include "client/session/edit_history.h"

#include <chrono>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/session/backoff.h"
#include "client/session/steady_clock.h"
#include "render/scene/field_error.h"
#include "render/scene/scene_difference.h"

namespace penumbra {
namespace {

// Others who commit at the same time make a commit on a certain revision fail. Who of them comes
// first next time is left to chance.
class Retries {
 public:
  explicit Retries(double patience_s)
      : patience_s_(patience_s), give_up_ms_(NowMs() + 1e3 * patience_s) {}

  // OK: try again; that took a pause. Otherwise what to tell of `error`.
  absl::Status PauseAfter(const absl::Status& error) const {
    if (ErrorReason(error) != "STALE_BASE") return error;
    if (NowMs() >= give_up_ms_) {
      return FieldError(error.code(), "STALE_BASE", ErrorFieldPath(error),
                        absl::StrCat("found that others commit faster than this could within ",
                                     patience_s_, " s; trying again helps"));
    }
    // Of the order of a round trip, so that those who collided are apart.
    constexpr double kPauseS = 0.01;
    std::this_thread::sleep_for(std::chrono::duration<double>(Jittered(kPauseS)));
    return absl::OkStatus();
  }

 private:
  const double patience_s_;
  const double give_up_ms_;
};

template <typename T>
const T* Find(const Scene::Table<T>& table, const std::string& id) {
  const auto found = table.find(id);
  return found == table.end() ? nullptr : found->second.get();
}

// The first object of this kind of `delta` that is not in `now` as it is in `left`.
template <typename T>
absl::Status CheckUnedited(const Scene::Table<T>& left, const Scene::Table<T>& now,
                           const std::vector<T>& upserts, const std::vector<std::string>& removals,
                           const char* kind) {
  std::vector<std::string> ids = removals;
  for (const T& object : upserts) ids.push_back(object.id);
  for (const std::string& id : ids) {
    const T* was = Find(left, id);
    const T* is = Find(now, id);
    if (was == is || (was && is && *was == *is)) continue;
    return FieldError(absl::StatusCode::kFailedPrecondition, "EDITED_SINCE",
                      absl::StrCat(kind, "[", id, "]"),
                      "found it edited since, need it as the edit left it");
  }
  return absl::OkStatus();
}

// Whether `delta` undoes nothing but what led to `left`.
absl::Status CheckUnedited(const Scene& left, const Scene& now, const SceneDelta& delta) {
  absl::Status status = CheckUnedited(left.instances(), now.instances(), delta.upsert_instances,
                                      delta.remove_instances, "instances");
  if (status.ok()) {
    status = CheckUnedited(left.lights(), now.lights(), delta.upsert_lights, delta.remove_lights,
                           "lights");
  }
  if (status.ok()) {
    status = CheckUnedited(left.receivers(), now.receivers(), delta.upsert_receivers,
                           delta.remove_receivers, "receivers");
  }
  return status;
}

}  // namespace

absl::StatusOr<EditHistory::Edit> EditHistory::CommitOnNewest(const SceneDelta& delta) {
  SceneDelta based = delta;
  const Retries retries(patience_s_);
  for (;;) {
    const auto before = engine_.Snapshot(scene_id_);
    if (!before.ok()) return before.status();
    if (!delta.base_revision) based.base_revision = (*before)->revision();
    const auto revision = engine_.Commit(scene_id_, based);
    if (!revision.ok()) {
      if (delta.base_revision) return revision.status();
      if (auto status = retries.PauseAfter(revision.status()); !status.ok()) return status;
      continue;
    }
    const auto after = (*before)->Apply(based);
    if (!after.ok()) return after.status();
    return Edit{*before, *after};
  }
}

absl::StatusOr<Revision> EditHistory::Commit(const SceneDelta& delta) {
  auto edit = CommitOnNewest(delta);
  if (!edit.ok()) return edit.status();
  undone_.clear();
  done_.push_back(*std::move(edit));
  if (done_.size() > max_edits_) done_.pop_front();
  return done_.back().after->revision();
}

absl::StatusOr<Revision> EditHistory::Turn(std::deque<Edit>& from, std::deque<Edit>& to,
                                           const char* nothing) {
  if (from.empty()) {
    return FieldError(absl::StatusCode::kFailedPrecondition, nothing, "history",
                      "found no edit, need one");
  }
  const Edit edit = from.back();
  SceneDelta back = Difference(*edit.after, *edit.before);
  const Retries retries(patience_s_);
  for (;;) {
    const auto now = engine_.Snapshot(scene_id_);
    if (!now.ok()) return now.status();
    if (auto status = CheckUnedited(*edit.after, **now, back); !status.ok()) {
      from.pop_back();
      return status;
    }
    back.base_revision = (*now)->revision();
    const auto revision = engine_.Commit(scene_id_, back);
    if (!revision.ok()) {
      if (auto status = retries.PauseAfter(revision.status()); !status.ok()) return status;
      continue;
    }
    from.pop_back();
    to.push_back({edit.after, edit.before});
    return revision;
  }
}

absl::StatusOr<Revision> EditHistory::Undo() { return Turn(done_, undone_, "NOTHING_TO_UNDO"); }

absl::StatusOr<Revision> EditHistory::Redo() { return Turn(undone_, done_, "NOTHING_TO_REDO"); }

}  // namespace penumbra
