// Blobs on their way down.

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "proto/convert/geometry_convert.h"
#include "render/scene/blob.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/studio.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds, std::chrono::seconds;

// Larger than what a connection takes in for a client that does not read.
std::shared_ptr<const Mesh> LargeMesh() {
  MeshGeometry geometry = UnitBoxGeometry();
  for (int i = 0; i < 20; ++i) {
    const std::vector<uint32_t> again(geometry.indices.begin(), geometry.indices.end());
    geometry.indices.insert(geometry.indices.end(), again.begin(), again.end());
    if (geometry.indices.size() > 4'000'000) break;
  }
  return MeshOf(std::move(geometry));
}

uint64_t SizeOf(const Mesh& mesh) { return EncodeBlob(mesh.geometry()).size(); }

TEST(DownloadTest, ThatStallsKeepsItsBlobCountedAndIsDroppedAfterAWhile) {
  const auto large = LargeMesh();
  ServerOptions options;
  options.limits.unused_blob_lifetime = seconds(0);
  options.limits.max_blob_store_bytes = SizeOf(*large) + 100;
  options.limits.transfer_idle_timeout = seconds(2);
  const auto server = StartServer(options);
  WireClient client(server->address());
  ASSERT_EQ(client.Upload(*large), absl::OkStatus());
  grpc::ClientContext context;
  v1::DownloadBlobRequest request;
  request.set_hash(ToProto(large->id()));
  const auto stalled = client.stub().DownloadBlob(&context, request);
  v1::DownloadBlobResponse response;
  ASSERT_TRUE(stalled->Read(&response));
  EXPECT_EQ(response.size_bytes(), SizeOf(*large));

  EXPECT_EQ(ErrorReason(client.Upload(*BoxMesh())), "QUOTA_BLOB_BYTES") << "it takes up its place";
  absl::Status later;
  const auto end = std::chrono::steady_clock::now() + kPatience / 2;
  do {
    std::this_thread::sleep_for(milliseconds(100));
    later = client.Upload(*BoxMesh());
  } while (!later.ok() && std::chrono::steady_clock::now() < end);
  EXPECT_EQ(later, absl::OkStatus()) << "a client that reads nothing does not hold it for ever";
  while (stalled->Read(&response)) {
  }
  EXPECT_EQ(stalled->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

}  // namespace
}  // namespace penumbra::testing
