#include "tests/load/load_client.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/support/channel_arguments.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/status_convert.h"
#include "tests/support/shapes.h"

namespace penumbra::load {

LoadClient::LoadClient(const std::string& address, std::string scene_id, Instance box)
    : scene_id_(std::move(scene_id)), box_(std::move(box)) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  stub_ = v1::PenumbraService::NewStub(
      grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
}

LoadClient::~LoadClient() {
  context_.TryCancel();
  if (reader_.joinable()) reader_.join();
}

absl::Status LoadClient::Open() {
  stream_ = stub_->Session(&context_);
  v1::SessionRequest request;
  request.mutable_hello()->add_protocol_versions(1);
  request.mutable_hello()->set_scene_id(scene_id_);
  request.mutable_hello()->set_mirror_scene(true);
  request.mutable_hello()->set_client_name("penumbra_load");
  stream_->Write(request);
  reader_ = std::thread([this] { Read(); });
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::seconds(20), [this] { return is_welcome_ || has_ended_; });
  return is_welcome_ ? absl::OkStatus() : absl::UnavailableError("no session opens");
}

void LoadClient::Commit(Clock::time_point due) {
  v1::SessionRequest request;
  {
    std::lock_guard lock(mutex_);
    SentCommit& commit = commits_.emplace_back();
    const size_t number = commits_.size() - 1;
    Instance moved = box_;
    moved.world_from_mesh =
        testing::Placed({0.001f * static_cast<float>(number % 4'000), 1.0f, 0.0f}, 0.3f);
    commit.delta.upsert_instances = {std::move(moved)};
    commit.due = due;
    commit.sent = Clock::now();
    request.mutable_commit()->set_commit_id(number);
    *request.mutable_commit()->mutable_delta() = ToProto(commit.delta);
  }
  stream_->Write(request);
}

bool LoadClient::AwaitAnswers(Clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  return changed_.wait_until(lock, deadline, [this] {
    return answers_ == commits_.size() || has_ended_;
  }) && answers_ == commits_.size();
}

bool LoadClient::AwaitRevision(Revision revision, Clock::time_point deadline) {
  std::unique_lock lock(mutex_);
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

void LoadClient::Read() {
  v1::SessionResponse response;
  while (stream_->Read(&response)) {
    std::lock_guard lock(mutex_);
    Receive(response);
    changed_.notify_all();
  }
  const absl::Status end = FromGrpcStatus(stream_->Finish());
  std::lock_guard lock(mutex_);
  has_ended_ = true;
  if (status_.ok() && !absl::IsCancelled(end)) status_ = end;
  changed_.notify_all();
}

void LoadClient::Receive(const v1::SessionResponse& response) {
  if (response.has_welcome()) is_welcome_ = true;
  if (response.has_scene_update() && !response.scene_update().is_continued()) {
    Tell(response.scene_update().revision(), response.scene_update().content_hash());
  }
  if (response.has_session_error()) status_ = FromProto(response.session_error().error());
  if (!response.has_commit_result()) return;
  const v1::CommitResult& result = response.commit_result();
  SentCommit& commit = commits_.at(result.commit_id());
  ++answers_;
  commit.answered = Clock::now();
  if (result.has_error()) {
    commit.error = FromProto(result.error()).ToString();
    return;
  }
  commit.revision = result.revision();
  commit.content_hash = result.content_hash();
  if (result.revision() == told_ + 1) Tell(result.revision(), result.content_hash());
}

void LoadClient::Tell(Revision revision, const std::string& hash) {
  if (revision < told_) {
    status_ = absl::DataLossError(absl::StrCat("revision ", revision, " after ", told_));
  }
  told_ = revision;
  told_hash_ = hash;
}

}  // namespace penumbra::load
