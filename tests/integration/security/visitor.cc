#include "tests/integration/security/visitor.h"

#include <chrono>
#include <utility>

#include "grpcpp/create_channel.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/blob.h"

namespace penumbra::testing {
namespace {

constexpr std::chrono::seconds kPatience{30};
constexpr char kService[] = "/penumbra.v1.PenumbraService/";

}  // namespace

VisitorCall::VisitorCall(grpc::Channel& channel, const std::string& path,
                         const std::vector<std::pair<std::string, std::string>>& headers) {
  context_.set_deadline(std::chrono::system_clock::now() + kPatience);
  for (const auto& [name, value] : headers) context_.AddMetadata(name, value);
  stream_.reset(
      grpc::internal::ClientReaderWriterFactory<grpc::ByteBuffer, grpc::ByteBuffer>::Create(
          &channel,
          grpc::internal::RpcMethod(path.c_str(), grpc::internal::RpcMethod::BIDI_STREAMING),
          &context_));
}

void VisitorCall::Send(const google::protobuf::Message& message) {
  const grpc::Slice slice(message.SerializeAsString());
  stream_->Write(grpc::ByteBuffer(&slice, 1));
}

bool VisitorCall::Read(google::protobuf::Message& message) {
  grpc::ByteBuffer bytes;
  if (!stream_->Read(&bytes)) return false;
  grpc::Slice slice;
  return bytes.DumpToSingleSlice(&slice).ok() &&
         message.ParseFromArray(slice.begin(), static_cast<int>(slice.size()));
}

absl::Status VisitorCall::End() {
  grpc::ByteBuffer rest;
  while (stream_->Read(&rest)) {
  }
  return FromGrpcStatus(stream_->Finish());
}

Visitor::Visitor(const std::string& address,
                 const std::shared_ptr<grpc::ChannelCredentials>& credentials,
                 const std::string& token) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  channel_ = grpc::CreateCustomChannel(address, credentials, arguments);
  if (!token.empty()) headers_ = {{"authorization", "Bearer " + token}};
}

void Visitor::ShowInstead(std::vector<std::string> authorizations) {
  headers_.clear();
  for (std::string& value : authorizations)
    headers_.emplace_back("authorization", std::move(value));
}

std::unique_ptr<VisitorCall> Visitor::Open(const std::string& call) {
  return std::make_unique<VisitorCall>(*channel_, kService + call, headers_);
}

absl::Status Visitor::Call(const std::string& call, const google::protobuf::Message& request,
                           google::protobuf::Message* response) {
  const auto open = Open(call);
  open->Send(request);
  open->SendNoMore();
  if (response) open->Read(*response);
  return open->End();
}

absl::Status Visitor::CallPath(const std::string& path) {
  VisitorCall call(*channel_, path, headers_);
  call.Send(v1::ListScenesRequest());
  call.SendNoMore();
  return call.End();
}

absl::Status Visitor::Create(const std::string& scene_id) {
  v1::CreateSceneRequest request;
  request.set_scene_id(scene_id);
  return Call("CreateScene", request);
}

absl::Status Visitor::Delete(const std::string& scene_id) {
  v1::DeleteSceneRequest request;
  request.set_scene_id(scene_id);
  return Call("DeleteScene", request);
}

std::vector<std::string> Visitor::List() {
  v1::ListScenesResponse response;
  std::vector<std::string> ids;
  if (!Call("ListScenes", v1::ListScenesRequest(), &response).ok()) return {"refused"};
  for (const auto& scene : response.scenes()) ids.push_back(scene.scene_id());
  return ids;
}

absl::Status Visitor::Export(const std::string& scene_id) {
  v1::ExportSceneRequest request;
  request.set_scene_id(scene_id);
  return Call("ExportScene", request);
}

absl::Status Visitor::Import(const std::string& scene_id) {
  v1::ImportSceneRequest request;
  request.set_scene_id(scene_id);
  return Call("ImportScene", request);
}

absl::Status Visitor::Upload(const Mesh& mesh) {
  const auto blob = EncodeBlob(mesh.geometry());
  v1::UploadBlobRequest request;
  request.mutable_header()->set_hash(ToProto(mesh.id()));
  request.mutable_header()->set_size_bytes(blob.size());
  request.set_data(blob.data(), blob.size());
  return Call("UploadBlob", request);
}

absl::Status Visitor::Download(const Mesh& mesh) {
  v1::DownloadBlobRequest request;
  request.set_hash(ToProto(mesh.id()));
  return Call("DownloadBlob", request);
}

absl::Status Visitor::Hello(VisitorCall& session, const std::string& scene_id) {
  v1::SessionRequest request;
  request.mutable_hello()->add_protocol_versions(1);
  request.mutable_hello()->set_scene_id(scene_id);
  session.Send(request);
  v1::SessionResponse response;
  return session.Read(response) ? absl::OkStatus() : session.End();
}

absl::Status Visitor::Commit(VisitorCall& session, const v1::SceneDelta& delta) {
  v1::SessionRequest request;
  request.mutable_commit()->set_commit_id(1);
  *request.mutable_commit()->mutable_delta() = delta;
  session.Send(request);
  v1::SessionResponse response;
  while (session.Read(response)) {
    if (response.has_commit_result()) return FromProto(response.commit_result().error());
  }
  return session.End();
}

}  // namespace penumbra::testing
