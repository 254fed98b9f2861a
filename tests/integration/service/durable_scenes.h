// A server that keeps its scenes on disk, and can be started anew on them.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "proto/convert/status_convert.h"
#include "tests/integration/service/kept_log.h"
#include "tests/integration/service/studio.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {

inline absl::Status ErrorIn(const v1::CommitResult& result) { return FromProto(result.error()); }

class DurableScenesTest : public ::testing::Test {
 protected:
  // Ends the server that is there, if any, and starts one on the same folder.
  void Restart() {
    session_.reset();
    client_.reset();
    server_.reset();
    options_.data_dir = folder_ / "data";
    options_.logger = &logger_;
    server_ = StartServer(options_);
    client_ = std::make_unique<WireClient>(server_->address());
  }
  void MakeStudio(const std::string& id = "studio") {
    ASSERT_EQ(client_->CreateScene(id), absl::OkStatus());
    ASSERT_EQ(client_->Upload(*BoxMesh()), absl::OkStatus());
    session_ = client_->OpenSession(id);
    ASSERT_EQ(session_->Commit(StudioDelta()).revision(), 1u);
  }
  // Of one that the server refuses.
  absl::Status EndOfSession(const std::string& scene_id) {
    WireSession session(client_->stub());
    v1::SessionRequest request;
    request.mutable_hello()->add_protocol_versions(1);
    request.mutable_hello()->set_scene_id(scene_id);
    session.Send(request);
    return session.End();
  }
  std::string SceneFileOf(const std::string& id) {
    return folder_ / ("data/scenes/" + id + "~1.db");
  }
  TemporaryFolder folder_;
  ServerOptions options_;
  KeptLog logger_;
  std::unique_ptr<PenumbraServer> server_;
  std::unique_ptr<WireClient> client_;
  std::unique_ptr<WireSession> session_;
};

}  // namespace penumbra::testing
