// Somebody who calls a server's calls by name, whatever their kind, and shows a token or none.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "google/protobuf/message.h"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/sync_stream.h"
#include "penumbra/v1/service.pb.h"
#include "render/scene/mesh.h"

namespace penumbra::testing {

// A call under way. Unary calls are streams of one message each way.
class VisitorCall {
 public:
  VisitorCall(grpc::Channel& channel, const std::string& path,
              const std::vector<std::pair<std::string, std::string>>& headers);

  void Send(const google::protobuf::Message& message);
  void SendNoMore() { stream_->WritesDone(); }
  // False once there are no more.
  bool Read(google::protobuf::Message& message);
  // Reads the rest, and says how the call ended.
  absl::Status End();

 private:
  using Stream = grpc::ClientReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>;
  grpc::ClientContext context_;
  std::unique_ptr<Stream> stream_;
};

class Visitor {
 public:
  // `token` is shown as "Bearer TOKEN"; empty: no header.
  Visitor(const std::string& address, const std::shared_ptr<grpc::ChannelCredentials>& credentials,
          const std::string& token);
  // The header as it is, for what is no bearer token; may come more than once.
  void ShowInstead(std::vector<std::string> authorizations);

  std::unique_ptr<VisitorCall> Open(const std::string& call);
  // One message, or none, and the end of the call.
  absl::Status Call(const std::string& call, const google::protobuf::Message& request,
                    google::protobuf::Message* response = nullptr);
  absl::Status CallPath(const std::string& path);

  // Of a scene's calls.
  absl::Status Create(const std::string& scene_id);
  absl::Status Delete(const std::string& scene_id);
  std::vector<std::string> List();
  absl::Status Export(const std::string& scene_id);
  // Of no records: whoever may import hears that the rest is missing.
  absl::Status Import(const std::string& scene_id);
  absl::Status Upload(const Mesh& mesh);
  absl::Status Download(const Mesh& mesh);
  // The error of a session's opening; OK: it is open.
  absl::Status Hello(VisitorCall& session, const std::string& scene_id);
  absl::Status Commit(VisitorCall& session, const v1::SceneDelta& delta);

 private:
  std::shared_ptr<grpc::Channel> channel_;
  std::vector<std::pair<std::string, std::string>> headers_;
};

}  // namespace penumbra::testing
