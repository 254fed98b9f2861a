// Starting and ending, in this process and as the program penumbrad.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "grpcpp/create_channel.h"
#include "render/scene/field_error.h"
#include "server/listen_address.h"
#include "tests/integration/service/studio.h"
#include "tests/load/process_usage.h"
#include "tests/support/daemon.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds, std::chrono::seconds;
using ::testing::HasSubstr;

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

TEST(PenumbradTest, C25SigtermEndsItAfterTellingItsSessions) {
  Daemon daemon({"--listen", "127.0.0.1:0", "--drain-seconds", "30"});
  WireClient client(daemon.Address());
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  auto session = client.OpenSession("studio");
  const auto start = std::chrono::steady_clock::now();
  daemon.Signal(SIGTERM);
  const absl::Status ended = session->End();
  EXPECT_EQ(ended.code(), absl::StatusCode::kUnavailable) << ended;
  EXPECT_EQ(ErrorReason(ended), "SHUTTING_DOWN");
  EXPECT_EQ(daemon.Wait(), 0);
  EXPECT_LT(SecondsSince(start), 10.0) << "an open session does not hold it up";
}

TEST(PenumbradTest, C25DrainingTakesNoLongerThanStated) {
  Daemon daemon({"--listen", "127.0.0.1:0", "--drain-seconds", "1"});
  WireClient client(daemon.Address());
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  grpc::ClientContext context;
  v1::UploadBlobResponse response;
  const auto endless = client.stub().UploadBlob(&context, &response);
  endless->Write(v1::UploadBlobRequest());  // refused, but never finished by this side
  grpc::ClientContext second_context;
  const auto silent = client.stub().UploadBlob(&second_context, &response);
  std::this_thread::sleep_for(milliseconds(200));
  const auto start = std::chrono::steady_clock::now();
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
  EXPECT_LT(SecondsSince(start), 5.0);
  EXPECT_FALSE(silent->Finish().ok());
  EXPECT_FALSE(endless->Finish().ok());
}

TEST(PenumbradTest, C25ASecondSigtermEndsItNow) {
  Daemon daemon({"--listen", "127.0.0.1:0", "--drain-seconds", "60"});
  WireClient client(daemon.Address());
  grpc::ClientContext context;
  v1::UploadBlobResponse response;
  const auto silent = client.stub().UploadBlob(&context, &response);
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  daemon.Signal(SIGTERM);
  std::this_thread::sleep_for(milliseconds(300));
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 128 + SIGTERM);
  EXPECT_FALSE(silent->Finish().ok());
}

TEST(PenumbradTest, StartUpErrorsAreOneLineAndAStatus) {
  Daemon first({"--listen", "127.0.0.1:0"});
  const std::string address = first.Address();
  Daemon second({"--listen", address});
  EXPECT_THAT(second.ErrorLine(),
              ::testing::AllOf(HasSubstr("listen"), HasSubstr(address), HasSubstr("in use")));
  EXPECT_EQ(second.ErrorLine(), "");
  EXPECT_EQ(second.Wait(), EXIT_FAILURE);
  for (const char* bad : {"0.0.0.0:0", "example.org:80", "127.0.0.1", "127.0.0.1:99999", "unix:"}) {
    Daemon daemon({"--listen", bad});
    EXPECT_THAT(daemon.ErrorLine(), ::testing::AllOf(HasSubstr("listen"), HasSubstr(bad)));
    EXPECT_EQ(daemon.Wait(), EXIT_FAILURE);
  }
  Daemon unknown({"--what"});
  EXPECT_THAT(unknown.ErrorLine(), HasSubstr("--what"));
  EXPECT_EQ(unknown.Wait(), EXIT_FAILURE);
}

TEST(PenumbradTest, WithoutTheEglDeviceItServesDegraded) {
  Daemon daemon({"--listen", "127.0.0.1:0", "--egl-device", "no-such-device"});
  WireClient client(daemon.Address());
  EXPECT_THAT(daemon.ErrorLine(), HasSubstr("degraded"));
  const auto info = client.ServerInfo();
  EXPECT_TRUE(info.is_degraded());
  EXPECT_THAT(info.gl().error(), HasSubstr("no-such-device"));
  EXPECT_EQ(client.CreateScene("studio"), absl::OkStatus());
}

TEST(PenumbradTest, AServerThatIsKilledEndsItsClientsCalls) {
  Daemon daemon({"--listen", "127.0.0.1:0"});
  WireClient client(daemon.Address());
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  auto session = client.OpenSession("studio");
  daemon.Signal(SIGKILL);
  EXPECT_EQ(session->End().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(client.CreateScene("other").code(), absl::StatusCode::kUnavailable);
}

// What a server holds once `count` more sessions have come and gone.
uint64_t ResidentBytesAfter(int count, const Daemon& daemon, WireClient& client) {
  for (int i = 0; i < count; ++i) {
    const auto session = client.OpenSession("studio", /*mirror_scene=*/true);
    session->ReadUntil(v1::SessionResponse::kSceneUpdate);
  }
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (client.ServerInfo().statistics().open_sessions() > 0 &&
         std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(milliseconds(10));
  }
  return load::UsageOf(daemon.pid()).resident_bytes;
}

TEST(PenumbradTest, SessionsThatHaveEndedLeaveNoMemoryBehind) {
  Daemon daemon({"--listen", "127.0.0.1:0"});
  WireClient client(daemon.Address());
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  [[maybe_unused]] const uint64_t before = ResidentBytesAfter(200, daemon, client);
  [[maybe_unused]] const uint64_t after = ResidentBytesAfter(1'000, daemon, client);
  EXPECT_EQ(client.ServerInfo().statistics().open_sessions(), 0u);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which have their own
  EXPECT_GT(before, 0u);
  EXPECT_LT(after, before + (24u << 20)) << "it grew by " << (after - before) / 1024 << " KiB";
#endif
}

TEST(PenumbraServerTest, ListensOnASocketFileAndNotOnOneInUse) {
  const std::string path =
      std::filesystem::temp_directory_path() / ("penumbra-test-" + std::to_string(getpid()));
  ServerOptions options;
  options.listen = "unix:" + path;
  options.opens_gl = false;
  const auto server = PenumbraServer::Start(options);
  ASSERT_TRUE(server.ok()) << server.status();
  EXPECT_EQ(WireClient((*server)->address()).CreateScene("studio"), absl::OkStatus());
  const auto second = PenumbraServer::Start(options);
  EXPECT_EQ(ErrorReason(second.status()), "CANNOT_LISTEN");
}

TEST(PenumbraServerTest, TellsOfItself) {
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.threads = 2;
  const auto server = PenumbraServer::Start(options);
  ASSERT_TRUE(server.ok()) << server.status();
  WireClient client((*server)->address());
  const auto info = client.ServerInfo();
  EXPECT_EQ(info.protocol_versions(0), 1u);
  EXPECT_EQ(info.thread_count(), 2u);
  EXPECT_EQ(info.limits().max_message_bytes(), 1u << 20);
  EXPECT_EQ(info.limits().max_lights(), SceneLimits().max_lights);
  EXPECT_EQ(info.limits().max_artifacts_per_scene(), ServerLimits().max_artifacts_per_scene);
  const auto& type = *info.limits().GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    EXPECT_TRUE(info.limits().GetReflection()->HasField(info.limits(), type.field(i)))
        << type.field(i)->name() << " is not told";
  }
  EXPECT_NE(info.gl().renderer().empty(), info.gl().error().empty());
  EXPECT_EQ(info.is_degraded(), info.gl().renderer().empty());
  grpc::ClientContext context;
  v1::ListTechniquesResponse techniques;
  ASSERT_TRUE(
      client.stub().ListTechniques(&context, v1::ListTechniquesRequest(), &techniques).ok());
  EXPECT_EQ(techniques.techniques(0).name(), "soft_texture");
  EXPECT_EQ(techniques.techniques(0).parameters(0).name(), "samples");
}

// A call by name with an empty message, for services whose stubs are not at hand.
grpc::StatusCode CallByName(WireClient& client, const char* method) {
  using Bytes = grpc::ByteBuffer;
  grpc::ClientContext context;
  const auto stream = std::unique_ptr<grpc::ClientReaderWriter<Bytes, Bytes>>(
      grpc::internal::ClientReaderWriterFactory<Bytes, Bytes>::Create(
          client.channel().get(),
          grpc::internal::RpcMethod(method, grpc::internal::RpcMethod::BIDI_STREAMING), &context));
  const grpc::Slice nothing("");
  stream->Write(Bytes(&nothing, 1));
  stream->WritesDone();
  Bytes answer;
  while (stream->Read(&answer)) {
  }
  return stream->Finish().error_code();
}

TEST(PenumbraServerTest, E09HealthIsServedAndReflectionOnlyOnRequest) {
  constexpr char kReflection[] = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo";
  const auto server = StartServer();
  WireClient client(server->address());
  EXPECT_EQ(CallByName(client, "/grpc.health.v1.Health/Check"), grpc::StatusCode::OK);
  EXPECT_EQ(CallByName(client, kReflection), grpc::StatusCode::UNIMPLEMENTED);
  ServerOptions options;
  options.reflection = true;
  const auto open_server = StartServer(options);
  WireClient other(open_server->address());
  EXPECT_EQ(CallByName(other, kReflection), grpc::StatusCode::OK);
}

TEST(PenumbraServerTest, A22RefusesCompressedMessages) {
  const auto server = StartServer();
  WireClient client(server->address());
  grpc::ClientContext context;
  context.set_compression_algorithm(GRPC_COMPRESS_GZIP);
  v1::CreateSceneRequest request;
  request.set_scene_id(std::string(100'000, 'a'));
  v1::CreateSceneResponse response;
  EXPECT_EQ(client.stub().CreateScene(&context, request, &response).error_code(),
            grpc::StatusCode::UNIMPLEMENTED);
}

TEST(PenumbraServerTest, B11AnUploadThatFallsSilentIsDropped) {
  ServerOptions options;
  options.limits.transfer_idle_timeout = seconds(1);
  const auto server = StartServer(options);
  WireClient client(server->address());
  grpc::ClientContext context;
  v1::UploadBlobResponse response;
  const auto writer = client.stub().UploadBlob(&context, &response);
  v1::UploadBlobRequest request;
  request.mutable_header()->set_hash(std::string(32, 'x'));
  request.mutable_header()->set_size_bytes(1'000'000);
  writer->Write(request);
  EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  // The client hears of the cancellation before the server has put the call away.
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (client.ServerInfo().statistics().blob_bytes() > 0 &&
         std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_EQ(client.ServerInfo().statistics().blob_bytes(), 0u);
}

TEST(PenumbraServerTest, ShutsDownWithSessionsOpen) {
  auto server = StartServer();
  WireClient client(server->address());
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  auto session = client.OpenSession("studio");
  auto done = std::async(std::launch::async, [&] { server.reset(); });
  ASSERT_EQ(done.wait_for(seconds(20)), std::future_status::ready);
}

}  // namespace
}  // namespace penumbra::testing
