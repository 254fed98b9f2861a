#include "tests/integration/service/wire_client.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

#include "grpcpp/create_channel.h"
#include "gtest/gtest.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/spec_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/blob.h"

namespace penumbra::testing {
namespace {

void GivePatience(grpc::ClientContext& context) {
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
}

}  // namespace

WireSession::WireSession(v1::PenumbraService::Stub& stub) {
  GivePatience(context_);
  stream_ = stub.Session(&context_);
}

WireSession::~WireSession() {
  if (!stream_) return;
  context_.TryCancel();
  End().IgnoreError();
}

void WireSession::Send(const v1::SessionRequest& request) { stream_->Write(request); }

std::optional<v1::SessionResponse> WireSession::Read() {
  v1::SessionResponse response;
  if (!stream_->Read(&response)) return std::nullopt;
  return response;
}

std::optional<v1::SessionResponse> WireSession::ReadUntil(v1::SessionResponse::ResponseCase kind) {
  while (auto response = Read()) {
    if (response->has_artifact_update()) Keep(response->artifact_update());
    if (response->response_case() == kind) return response;
  }
  ADD_FAILURE() << "the server ended the call while the test waited for response " << kind;
  return std::nullopt;
}

absl::Status WireSession::End() {
  v1::SessionResponse rest;
  while (stream_->Read(&rest)) {
  }
  const absl::Status status = FromGrpcStatus(stream_->Finish());
  stream_ = nullptr;
  return status;
}

v1::Welcome WireSession::Greet(const v1::Hello& hello) {
  v1::SessionRequest request;
  *request.mutable_hello() = hello;
  request.mutable_hello()->add_protocol_versions(1);
  Send(request);
  const auto response = ReadUntil(v1::SessionResponse::kWelcome);
  return response ? response->welcome() : v1::Welcome();
}

v1::Welcome WireSession::Hello(const std::string& scene_id, bool mirror_scene) {
  v1::Hello hello;
  hello.set_scene_id(scene_id);
  hello.set_mirror_scene(mirror_scene);
  return Greet(hello);
}

v1::Welcome WireSession::Resume(const std::string& scene_id, const std::string& incarnation,
                                Revision revision, const std::string& content_hash) {
  v1::Hello hello;
  hello.set_scene_id(scene_id);
  hello.set_mirror_scene(true);
  hello.mutable_resume()->set_incarnation(incarnation);
  hello.mutable_resume()->set_revision(revision);
  hello.mutable_resume()->set_content_hash(content_hash);
  return Greet(hello);
}

v1::CommitResult WireSession::Commit(const SceneDelta& delta, const std::string& key) {
  return Commit(ToProto(delta), key);
}

v1::CommitResult WireSession::Commit(const v1::SceneDelta& delta, const std::string& key) {
  v1::SessionRequest request;
  request.mutable_commit()->set_commit_id(next_commit_id_++);
  *request.mutable_commit()->mutable_delta() = delta;
  request.mutable_commit()->set_idempotency_key(key);
  Send(request);
  const auto response = ReadUntil(v1::SessionResponse::kCommitResult);
  if (!response) return {};
  EXPECT_EQ(response->commit_result().commit_id(), request.commit().commit_id());
  return response->commit_result();
}

absl::Status WireSession::Subscribe(uint64_t id, const ArtifactSpec& spec, uint32_t credit) {
  v1::SessionRequest request;
  request.mutable_subscribe()->set_subscription_id(id);
  *request.mutable_subscribe()->mutable_spec() = ToProto(spec);
  request.mutable_subscribe()->set_initial_credit(credit);
  Send(request);
  const auto response = ReadUntil(v1::SessionResponse::kSubscribeResult);
  if (!response) return absl::UnavailableError("no answer");
  EXPECT_EQ(response->subscribe_result().subscription_id(), id);
  return FromProto(response->subscribe_result().error());
}

void WireSession::GrantCredit(uint64_t id, uint32_t updates) {
  v1::SessionRequest request;
  request.mutable_credit()->set_subscription_id(id);
  request.mutable_credit()->set_updates(updates);
  Send(request);
}

void WireSession::Acknowledge(uint64_t id) {
  v1::SessionRequest request;
  request.mutable_acknowledgement()->set_subscription_id(id);
  request.mutable_acknowledgement()->set_update_sequence(receptions_[id].assembler.sequence());
  Send(request);
}

void WireSession::Keep(const v1::ArtifactUpdate& message) {
  update_bytes_ += message.ByteSizeLong();
  ++update_messages_;
  update_tiles_ += static_cast<uint64_t>(message.tiles_size());
  Reception& reception = receptions_[message.subscription_id()];
  auto update = reception.assembler.Add(message);
  ASSERT_TRUE(update.ok()) << update.status();
  if (update->has_value()) reception.updates.push_back(**std::move(update));
}

ArtifactUpdate WireSession::AwaitUpdate(
    uint64_t id, const std::function<bool(const ArtifactUpdate&)>& is_wanted) {
  for (;;) {
    auto& updates = receptions_[id].updates;
    while (!updates.empty()) {
      ArtifactUpdate update = std::move(updates.front());
      updates.pop_front();
      Acknowledge(id);
      GrantCredit(id, 1);
      if (is_wanted(update)) return update;
    }
    if (!ReadUntil(v1::SessionResponse::kArtifactUpdate)) return {};
  }
}

WireClient::WireClient(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetMaxReceiveMessageSize(1 << 20);  // the most that the protocol allows
  // What ServerConnection::Greet says of gRPC's errno: a first failure need not be one.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  channel_ = grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
  EXPECT_TRUE(channel_->WaitForConnected(std::chrono::system_clock::now() + kPatience));
  stub_ = v1::PenumbraService::NewStub(channel_);
}

absl::Status WireClient::CreateScene(const std::string& scene_id) {
  grpc::ClientContext context;
  GivePatience(context);
  v1::CreateSceneRequest request;
  request.set_scene_id(scene_id);
  v1::CreateSceneResponse response;
  return FromGrpcStatus(stub_->CreateScene(&context, request, &response));
}

absl::Status WireClient::DeleteScene(const std::string& scene_id) {
  grpc::ClientContext context;
  GivePatience(context);
  v1::DeleteSceneRequest request;
  request.set_scene_id(scene_id);
  v1::DeleteSceneResponse response;
  return FromGrpcStatus(stub_->DeleteScene(&context, request, &response));
}

absl::StatusOr<std::vector<SceneInfo>> WireClient::ListScenes() {
  grpc::ClientContext context;
  GivePatience(context);
  v1::ListScenesResponse response;
  const auto status = stub_->ListScenes(&context, v1::ListScenesRequest(), &response);
  if (!status.ok()) return FromGrpcStatus(status);
  std::vector<SceneInfo> infos;
  for (const auto& scene : response.scenes()) infos.push_back(FromProto(scene).value());
  return infos;
}

absl::StatusOr<SceneInfo> WireClient::FindScene(const std::string& scene_id) {
  const auto infos = ListScenes();
  if (!infos.ok()) return infos.status();
  for (const SceneInfo& info : *infos) {
    if (info.id == scene_id) return info;
  }
  return absl::NotFoundError(scene_id);
}

v1::GetServerInfoResponse WireClient::ServerInfo() {
  grpc::ClientContext context;
  GivePatience(context);
  v1::GetServerInfoResponse response;
  const auto status = stub_->GetServerInfo(&context, v1::GetServerInfoRequest(), &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return response;
}

absl::StatusOr<std::vector<std::string>> WireClient::FindMissing(
    const std::vector<std::string>& hashes) {
  grpc::ClientContext context;
  GivePatience(context);
  v1::FindMissingBlobsRequest request;
  request.mutable_hashes()->Add(hashes.begin(), hashes.end());
  v1::FindMissingBlobsResponse response;
  const auto status = stub_->FindMissingBlobs(&context, request, &response);
  if (!status.ok()) return FromGrpcStatus(status);
  return std::vector<std::string>(response.missing_hashes().begin(),
                                  response.missing_hashes().end());
}

absl::Status WireClient::Upload(const Mesh& mesh, size_t chunk) {
  const auto blob = EncodeBlob(mesh.geometry());
  std::vector<v1::UploadBlobRequest> requests(1);
  requests[0].mutable_header()->set_hash(ToProto(mesh.id()));
  requests[0].mutable_header()->set_size_bytes(blob.size());
  for (size_t at = 0; at < blob.size(); at += chunk) {
    requests.emplace_back().set_data(blob.data() + at, std::min(chunk, blob.size() - at));
  }
  return Upload(requests).status();
}

absl::StatusOr<v1::UploadBlobResponse> WireClient::Upload(
    const std::vector<v1::UploadBlobRequest>& requests) {
  grpc::ClientContext context;
  GivePatience(context);
  v1::UploadBlobResponse response;
  const auto writer = stub_->UploadBlob(&context, &response);
  for (const auto& request : requests) {
    if (!writer->Write(request)) break;
  }
  writer->WritesDone();
  const auto status = writer->Finish();
  if (!status.ok()) return FromGrpcStatus(status);
  return response;
}

absl::StatusOr<std::string> WireClient::Download(const ContentHash& hash) {
  grpc::ClientContext context;
  GivePatience(context);
  v1::DownloadBlobRequest request;
  request.set_hash(ToProto(hash));
  const auto reader = stub_->DownloadBlob(&context, request);
  std::string bytes;
  v1::DownloadBlobResponse response;
  while (reader->Read(&response)) bytes += response.data();
  const auto status = reader->Finish();
  if (!status.ok()) return FromGrpcStatus(status);
  return bytes;
}

std::unique_ptr<WireSession> WireClient::OpenSession(const std::string& scene_id,
                                                     bool mirror_scene) {
  auto session = std::make_unique<WireSession>(*stub_);
  session->Hello(scene_id, mirror_scene);
  return session;
}

bool IsFinal(const ArtifactUpdate& update) {
  return update.artifact && update.artifact->header.is_final;
}

std::function<bool(const ArtifactUpdate&)> FinalAt(Revision revision) {
  return [revision](const ArtifactUpdate& update) {
    return IsFinal(update) && update.revision >= revision;
  };
}

const SoftShadowTexture& TextureOf(const ArtifactUpdate& update) {
  return std::get<SoftShadowTexture>(update.artifact->payload);
}

}  // namespace penumbra::testing
