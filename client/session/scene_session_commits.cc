// The commits of a SceneSession.

#include <chrono>

#include "absl/strings/str_cat.h"
#include "client/session/backoff.h"
#include "client/session/blob_transfer.h"
#include "client/session/scene_session.h"
#include "client/session/server_connection.h"
#include "client/session/steady_clock.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"

namespace penumbra {

absl::StatusOr<Revision> SceneSession::Commit(const SceneDelta& delta) {
  auto revision = TryCommit(delta);
  // The server may have dropped a blob between our question and the commit, or since an instance
  // named it that is gone by now.
  if (ErrorReason(revision.status()) != "MISSING_BLOB") return revision;
  const auto nothing_known = Scene::Empty(scene_id_);
  const absl::Status status = Upload(delta, *nothing_known);
  if (!status.ok()) return status;
  return TryCommit(delta);
}

// Again, once there is a connection again.
absl::Status SceneSession::Upload(const SceneDelta& delta, const Scene& known) {
  for (;;) {
    const absl::Status status = connection_.blobs().UploadMissing(delta, known);
    if (!absl::IsUnavailable(status)) return status;
    std::unique_lock lock(mutex_);
    // The stream may be about to find out too.
    constexpr std::chrono::seconds kStreamsVerdict{1};
    changed_.wait_for(lock, kStreamsVerdict, [this] { return !is_connected_ || has_ended_; });
    if (is_connected_ || has_ended_) return status;
    changed_.wait(lock, [this] { return is_connected_ || has_ended_; });
  }
}

// A server that has no room says how long to wait: the commit is then sent again, under its key.
absl::StatusOr<Revision> SceneSession::TryCommit(const SceneDelta& delta) {
  const auto known = mirror_.Applied();
  absl::Status status = Upload(delta, *known);
  if (!status.ok()) return status;

  v1::SessionRequest request;
  *request.mutable_commit()->mutable_delta() = ToProto(delta);
  status = connection_.CheckFits(request, "delta", ": commit it in parts");
  if (!status.ok()) return status;
  {
    std::lock_guard lock(mutex_);
    request.mutable_commit()->set_idempotency_key(absl::StrCat(key_prefix_, next_id_++));
  }
  const double give_up_ms = NowMs() + 1e3 * connection_.options().call_timeout_s;
  for (;;) {
    auto revision = CommitOnce(delta, request);
    const auto delay_ms = RetryDelayMs(revision.status());
    if (!delay_ms || NowMs() + *delay_ms > give_up_ms) return revision;
    if (!WaitToTryAgain(JitteredAfter(1e-3 * *delay_ms))) return revision;
  }
}

absl::StatusOr<Revision> SceneSession::CommitOnce(const SceneDelta& delta,
                                                  v1::SessionRequest& request) {
  const auto answer = std::make_shared<Answer>();
  answer->delta = delta;
  {
    std::lock_guard lock(mutex_);
    request.mutable_commit()->set_commit_id(next_id_);
    answer->request = request;
    commits_[next_id_++] = answer;
  }
  SendOnce(*answer);
  const absl::Status status = Await(commits_, request.commit().commit_id(), answer);
  if (ErrorReason(status) == "NOT_EDITOR") return Named(status);
  if (!status.ok()) return status;
  // The next commit then knows which meshes this one has brought. What others brought may have to
  // be fetched, which is for Snapshot to wait for.
  mirror_.CatchUpOwn();
  return answer->revision;
}

}  // namespace penumbra
