// ImportScene, message by message, and a server on disk that has the small archive's mesh.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "proto/convert/status_convert.h"
#include "tests/integration/service/durable_scenes.h"
#include "tests/support/small_archive.h"

namespace penumbra::testing {

using Records = std::vector<v1::ArchiveRecord>;

class ImportCall {
 public:
  explicit ImportCall(WireClient& client)
      : writer_(client.stub().ImportScene(&context_, &response_)) {}
  bool Send(const std::string& scene_id, const Records& records) {
    v1::ImportSceneRequest request;
    request.set_scene_id(scene_id);
    for (const auto& record : records) *request.add_records() = record;
    return writer_->Write(request);
  }
  void Cancel() { context_.TryCancel(); }
  absl::Status End() {
    writer_->WritesDone();
    return FromGrpcStatus(writer_->Finish());
  }
  const v1::SceneInfo& scene() const { return response_.scene(); }

 private:
  grpc::ClientContext context_;
  v1::ImportSceneResponse response_;
  std::unique_ptr<grpc::ClientWriter<v1::ImportSceneRequest>> writer_;
};

class ImportTest : public DurableScenesTest {
 protected:
  void SetUp() override {
    Restart();
    ASSERT_EQ(client_->Upload(*BoxMesh()), absl::OkStatus());
  }
  absl::Status Import(const Records& records, const std::string& id = "studio") {
    ImportCall call(*client_);
    call.Send(id, records);
    return call.End();
  }
};

}  // namespace penumbra::testing
