#include "tests/load/open_client.h"

#include <utility>

#include "client/session/backoff.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/retry_delay.h"
#include "tests/load/own_channel.h"
#include "tests/support/shapes.h"

namespace penumbra::load {

OpenClient::OpenClient(const std::string& address, std::string scene_id, Instance box, bool is_deaf)
    : scene_id_(std::move(scene_id)),
      box_(std::move(box)),
      is_deaf_(is_deaf),
      stub_(v1::PenumbraService::NewStub(OwnChannel(address))) {}

absl::Status OpenClient::Open() {
  stream_ =
      std::make_unique<Stream>([this](const v1::SessionResponse& response) { Receive(response); },
                               [this](const grpc::Status& status) { End(status); });
  stream_->Begin([this](grpc::ClientContext* context, Stream* stream) {
    stub_->async()->Session(context, stream);
  });
  v1::SessionRequest request;
  v1::Hello& hello = *request.mutable_hello();
  hello.add_protocol_versions(1);
  hello.set_scene_id(scene_id_);
  hello.set_mirror_scene(true);
  hello.set_client_name("penumbra_load");
  stream_->Send(std::move(request));
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::seconds(20), [this] { return is_welcome_ || is_done_; });
  return is_welcome_ ? absl::OkStatus() : absl::UnavailableError("no session opens");
}

void OpenClient::Commit(Clock::time_point due) {
  uint64_t id = 0;
  {
    std::lock_guard lock(mutex_);
    records_.push_back({.due = due});
    if (is_done_) return;
    if (!is_deaf_ && Clock::now() < wait_until_) {
      records_.back().fate = CommitRecord::Fate::kHeld;
      return;
    }
    ++open_;
    id = first_id_ + records_.size() - 1;
  }
  stream_->Send(Move(id));
}

v1::SessionRequest OpenClient::Move(uint64_t id) const {
  Instance moved = box_;
  moved.world_from_mesh =
      testing::Placed({0.001f * static_cast<float>(id % 4'000), 1.0f, 0.0f}, 0.3f);
  SceneDelta delta;
  delta.upsert_instances = {std::move(moved)};
  v1::SessionRequest request;
  request.mutable_commit()->set_commit_id(id);
  *request.mutable_commit()->mutable_delta() = ToProto(delta);
  return request;
}

void OpenClient::Receive(const v1::SessionResponse& response) {
  std::lock_guard lock(mutex_);
  is_welcome_ = is_welcome_ || response.has_welcome();
  if (response.has_commit_result()) Receive(response.commit_result());
  changed_.notify_all();
}

void OpenClient::Receive(const v1::CommitResult& result) {
  --open_;
  absl::Status error;
  if (result.has_error()) error = FromProto(result.error());
  const auto now = Clock::now();
  const auto delay_ms = RetryDelayMs(error);
  if (delay_ms) {
    const std::chrono::duration<double, std::milli> wait(JitteredAfter(*delay_ms));
    wait_until_ = now + std::chrono::duration_cast<Clock::duration>(wait);
  }
  if (result.commit_id() < first_id_) return;
  CommitRecord& record = records_.at(result.commit_id() - first_id_);
  record.fate = error.ok() ? CommitRecord::Fate::kAccepted : CommitRecord::Fate::kRefused;
  record.answered = now;
  record.is_told_to_wait = delay_ms.has_value();
}

void OpenClient::End(const grpc::Status& status) {
  std::lock_guard lock(mutex_);
  is_done_ = true;
  const absl::Status end = FromGrpcStatus(status);
  if (!absl::IsCancelled(end)) status_ = end;
  changed_.notify_all();
}

bool OpenClient::AwaitAnswers(Clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, deadline, [this] { return open_ == 0 || is_done_; });
  return open_ == 0;
}

std::vector<CommitRecord> OpenClient::TakeRecords() {
  std::lock_guard lock(mutex_);
  first_id_ += records_.size();
  return std::exchange(records_, {});
}

absl::Status OpenClient::status() const {
  std::lock_guard lock(mutex_);
  return status_;
}

}  // namespace penumbra::load
