#include "tests/load/load_client.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/status_convert.h"
#include "tests/load/own_channel.h"
#include "tests/support/shapes.h"

namespace penumbra::load {

LoadClient::LoadClient(const std::string& address, std::string scene_id, Instance box)
    : scene_id_(std::move(scene_id)),
      box_(std::move(box)),
      stub_(v1::PenumbraService::NewStub(OwnChannel(address))) {}

LoadClient::~LoadClient() { stream_.reset(); }

absl::Status LoadClient::Open() {
  stream_ = std::make_unique<Stream>(
      [this](const v1::SessionResponse& response) {
        std::lock_guard lock(mutex_);
        Receive(response);
      },
      [this](const grpc::Status& status) { End(FromGrpcStatus(status)); });
  stream_->Begin([this](grpc::ClientContext* context, Stream* stream) {
    stub_->async()->Session(context, stream);
  });
  v1::SessionRequest request;
  request.mutable_hello()->add_protocol_versions(1);
  request.mutable_hello()->set_scene_id(scene_id_);
  request.mutable_hello()->set_mirror_scene(true);
  request.mutable_hello()->set_client_name("penumbra_load");
  stream_->Send(std::move(request));
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::seconds(20), [this] { return is_welcome_ || has_ended_; });
  return is_welcome_ ? absl::OkStatus() : absl::UnavailableError("no session opens");
}

void LoadClient::Commit(Clock::time_point due) {
  size_t number = 0;
  {
    std::lock_guard lock(mutex_);
    number = commits_.size();
  }
  Instance moved = box_;
  moved.world_from_mesh =
      testing::Placed({0.001f * static_cast<float>(number % 4'000), 1.0f, 0.0f}, 0.3f);
  SceneDelta delta;
  delta.upsert_instances = {std::move(moved)};
  Commit(due, std::move(delta));
}

void LoadClient::Commit(Clock::time_point due, SceneDelta delta) {
  v1::SessionRequest request;
  {
    std::lock_guard lock(mutex_);
    SentCommit& commit = commits_.emplace_back();
    const size_t number = commits_.size() - 1;
    commit.delta = std::move(delta);
    commit.due = due;
    commit.sent = Clock::now();
    request.mutable_commit()->set_commit_id(number);
    *request.mutable_commit()->mutable_delta() = ToProto(commit.delta);
  }
  stream_->Send(std::move(request));
}

bool LoadClient::AwaitAnswers(Clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  return changed_.wait_until(lock, deadline, [this] {
    return answers_ == commits_.size() || has_ended_;
  }) && answers_ == commits_.size();
}

bool LoadClient::AwaitRevision(Revision revision, Clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  is_awaited_ = true;
  return changed_.wait_until(lock, deadline, [&] { return told_ >= revision || has_ended_; }) &&
         told_ >= revision;
}

Revision LoadClient::told_revision() const {
  std::lock_guard lock(mutex_);
  return told_;
}

std::string LoadClient::told_hash() const {
  std::lock_guard lock(mutex_);
  return told_hash_;
}

absl::Status LoadClient::status() const {
  std::lock_guard lock(mutex_);
  return status_;
}

void LoadClient::End(const absl::Status& status) {
  std::lock_guard lock(mutex_);
  has_ended_ = true;
  if (status_.ok() && !absl::IsCancelled(status)) status_ = status;
  changed_.notify_all();
}

void LoadClient::Receive(const v1::SessionResponse& response) {
  // Those who wait, do so for the beginning and the end.
  if (response.has_welcome()) {
    is_welcome_ = true;
    changed_.notify_all();
  }
  if (response.has_scene_update()) Receive(response.scene_update());
  if (response.has_session_error()) status_ = FromProto(response.session_error().error());
  if (!response.has_commit_result()) return;
  const v1::CommitResult& result = response.commit_result();
  SentCommit& commit = commits_.at(result.commit_id());
  ++answers_;
  if (answers_ == commits_.size()) changed_.notify_all();
  commit.answered = Clock::now();
  if (result.has_error()) {
    commit.error = FromProto(result.error()).ToString();
    return;
  }
  commit.revision = result.revision();
  commit.content_hash = result.content_hash();
  if (result.revision() == told_ + 1) Tell(result.revision(), result.content_hash());
}

void LoadClient::Receive(const v1::SceneUpdate& update) {
  if (!update.is_snapshot() && update.from_revision() != told_) {
    status_ = absl::DataLossError(
        absl::StrCat("a change from revision ", update.from_revision(), " after ", told_));
  }
  if (!update.is_continued()) Tell(update.revision(), update.content_hash());
}

void LoadClient::Tell(Revision revision, const std::string& hash) {
  if (revision < told_) {
    status_ = absl::DataLossError(absl::StrCat("revision ", revision, " after ", told_));
  }
  told_ = revision;
  told_hash_ = hash;
  if (is_awaited_) changed_.notify_all();
}

}  // namespace penumbra::load
