// A server whose GL fails: its clients get their artifacts, its operators are told.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>

#include <atomic>

#include "penumbra/v1/service.grpc.pb.h"
#include "render/scene/field_error.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

ArtifactSpec GlSpec() {
  return {SoftTextureParams{.method = VisibilityMethod::kGl}, "lamp", "floor"};
}

v1::GetServerInfoResponse InfoOf(const std::string& address) {
  const auto stub = v1::PenumbraService::NewStub(
      grpc::CreateChannel(address, grpc::InsecureChannelCredentials()));
  grpc::ClientContext context;
  v1::GetServerInfoResponse info;
  EXPECT_TRUE(stub->GetServerInfo(&context, {}, &info).ok());
  return info;
}

// What grpc.health.v1 says of a service, by the bytes of its messages: 1 serving, 2 not serving.
int HealthOf(const std::string& address, const std::string& service) {
  using Bytes = grpc::ByteBuffer;
  const auto channel = grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
  grpc::ClientContext context;
  const grpc::internal::RpcMethod method("/grpc.health.v1.Health/Check",
                                         grpc::internal::RpcMethod::BIDI_STREAMING);
  const std::unique_ptr<grpc::ClientReaderWriter<Bytes, Bytes>> call(
      grpc::internal::ClientReaderWriterFactory<Bytes, Bytes>::Create(channel.get(), method,
                                                                      &context));
  const char field[] = {'\x0a', static_cast<char>(service.size())};
  const grpc::Slice request(std::string(field, sizeof(field)).append(service));
  call->Write(Bytes(&request, 1));
  call->WritesDone();
  Bytes answer;
  std::vector<grpc::Slice> slices;
  EXPECT_TRUE(call->Read(&answer) && answer.Dump(&slices).ok());
  EXPECT_TRUE(call->Finish().ok());
  return slices.empty() || slices[0].size() != 2 ? -1 : slices[0].begin()[1];
}

TEST(GlFailuresTest, ThreeLossesDegradeTheServerAndFailNoSubscription) {
  std::atomic<int> losses_left = 0;
  const auto server = PenumbraServer::Start({.listen = "127.0.0.1:0",
                                             .egl_device = "software",
                                             .inject_gl_fault = [&](std::string_view what) {
                                               if (what != "gl::Worker" || losses_left == 0)
                                                 return gl::Fault::kNone;
                                               --losses_left;
                                               return gl::Fault::kLost;
                                             }});
  ASSERT_TRUE(server.ok()) << server.status();
  const std::string& address = (*server)->address();
  EXPECT_EQ(HealthOf(address, "penumbra.gl"), 1);
  auto engine = RemoteEngine::Connect({.address = address});
  ASSERT_TRUE(engine.ok()) << engine.status();
  ASSERT_TRUE((*engine)->CreateScene("s").ok());
  ASSERT_TRUE((*engine)->Commit("s", Studio()).ok());
  const auto by_gl = ComputeOnce(**engine, "s", GlSpec());
  ASSERT_TRUE(by_gl.ok()) << by_gl.status();
  for (int loss = 0; loss < 3; ++loss) {
    EXPECT_FALSE(InfoOf(address).is_degraded()) << loss;
    losses_left = 1;
    const auto again = ComputeOnce(**engine, "s", GlSpec());
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_EQ(CountsOf(**again), CountsOf(**by_gl));
  }
  const auto info = InfoOf(address);
  EXPECT_TRUE(info.is_degraded());
  EXPECT_THAT(info.gl().error(), HasSubstr("context was lost"));
  EXPECT_THAT(info.gl().renderer(), HasSubstr("llvmpipe"));
  EXPECT_TRUE((*server)->is_degraded());
  EXPECT_EQ(HealthOf(address, "penumbra.gl"), 2);
  EXPECT_EQ(HealthOf(address, v1::PenumbraService::service_full_name()), 1);
  const auto by_cpu = ComputeOnce(**engine, "s", GlSpec());
  ASSERT_TRUE(by_cpu.ok()) << by_cpu.status();
  EXPECT_THAT((*by_cpu)->header.parameters.at("without_gl"), HasSubstr("context was lost"));
}

TEST(GlFailuresTest, GpuMemoryHasTheLimitThatIsAskedFor) {
  const auto server = PenumbraServer::Start(
      {.listen = "127.0.0.1:0", .egl_device = "software", .gpu_memory_bytes = 10'000});
  ASSERT_TRUE(server.ok()) << server.status();
  auto engine = RemoteEngine::Connect({.address = (*server)->address()});
  ASSERT_TRUE(engine.ok()) << engine.status();
  ASSERT_TRUE((*engine)->CreateScene("s").ok());
  ASSERT_TRUE((*engine)->Commit("s", Studio()).ok());
  const absl::Status refused = ComputeOnce(**engine, "s", GlSpec()).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted) << refused;
  EXPECT_EQ(ErrorReason(refused), "QUOTA_GPU_BYTES");
  EXPECT_THAT(std::string(refused.message()), HasSubstr("need at most 10000"));
  EXPECT_TRUE(ComputeOnce(**engine, "s", FloorSpec()).ok());
  EXPECT_FALSE((*server)->is_degraded());
}

TEST(GlFailuresTest, ARequiredGpuIsNoSoftwareDevice) {
  const auto server = PenumbraServer::Start(
      {.listen = "127.0.0.1:0", .egl_device = "software", .require_gpu = true});
  EXPECT_EQ(server.status().code(), absl::StatusCode::kFailedPrecondition) << server.status();
  EXPECT_EQ(ErrorReason(server.status()), "NO_GPU");
  EXPECT_THAT(std::string(server.status().message()), HasSubstr("software"));
}

}  // namespace
}  // namespace penumbra::testing
