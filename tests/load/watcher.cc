#include "tests/load/watcher.h"

#include <utility>

#include "proto/convert/spec_convert.h"
#include "proto/convert/status_convert.h"
#include "tests/load/own_channel.h"

namespace penumbra::load {
namespace {

constexpr uint64_t kSubscription = 1;
constexpr uint32_t kCredit = 1'000'000;
constexpr std::chrono::seconds kPatience{30};

}  // namespace

Watcher::Watcher(const std::string& address, std::string scene_id, ArtifactSpec spec,
                 Options options)
    : scene_id_(std::move(scene_id)),
      spec_(std::move(spec)),
      options_(std::move(options)),
      stub_(v1::PenumbraService::NewStub(OwnChannel(address))) {}

Watcher::~Watcher() {
  is_closing_ = true;
  context_.TryCancel();
  if (reader_.joinable()) reader_.join();
}

absl::Status Watcher::Open() {
  stream_ = stub_->Session(&context_);
  v1::SessionRequest hello, subscribe;
  hello.mutable_hello()->add_protocol_versions(1);
  hello.mutable_hello()->set_scene_id(scene_id_);
  hello.mutable_hello()->set_client_name("penumbra_load");
  subscribe.mutable_subscribe()->set_subscription_id(kSubscription);
  *subscribe.mutable_subscribe()->mutable_spec() = ToProto(spec_);
  subscribe.mutable_subscribe()->set_initial_credit(kCredit);
  stream_->Write(hello);
  stream_->Write(subscribe);
  reader_ = std::thread([this] { Read(); });
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, kPatience, [this] { return has_update_ || has_ended_; });
  if (has_update_) return absl::OkStatus();
  return status_.ok() ? absl::UnavailableError("no update comes") : status_;
}

std::vector<Arrival> Watcher::TakeArrivals() {
  std::lock_guard lock(mutex_);
  return std::exchange(arrivals_, {});
}

bool Watcher::AwaitRevision(Revision revision, std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  return changed_.wait_until(lock, deadline, [&] { return newest_ >= revision || has_ended_; }) &&
         newest_ >= revision;
}

absl::Status Watcher::status() const {
  std::lock_guard lock(mutex_);
  return status_;
}

void Watcher::Read() {
  v1::SessionResponse response;
  while (stream_->Read(&response)) {
    received_bytes_ += response.ByteSizeLong();
    if (response.has_artifact_update()) Take(response.artifact_update());
    while (!options_.reads && has_update_ && !is_closing_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  const absl::Status end = FromGrpcStatus(stream_->Finish());
  std::lock_guard lock(mutex_);
  has_ended_ = true;
  if (!is_closing_) status_ = end;
  changed_.notify_all();
}

void Watcher::Take(const v1::ArtifactUpdate& update) {
  if (options_.on_message) options_.on_message(update);
  {
    std::lock_guard lock(mutex_);
    has_artifact_ = has_artifact_ || update.has_header();
    if (update.revision() > 0) newest_ = update.revision();
    if (!update.end_of_update()) return;
    arrivals_.push_back({.revision = newest_,
                         .is_new = std::exchange(has_artifact_, false),
                         .time = std::chrono::steady_clock::now()});
    has_update_ = true;
    changed_.notify_all();
  }
  if (!options_.acknowledges || !update.end_of_update()) return;
  v1::SessionRequest request;
  request.mutable_acknowledgement()->set_subscription_id(kSubscription);
  request.mutable_acknowledgement()->set_update_sequence(update.update_sequence());
  stream_->Write(request);
}

}  // namespace penumbra::load
