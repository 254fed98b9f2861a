// C12 and E05: what a listener with TLS refuses; certificates that change.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdio.h>

#include <chrono>
#include <cstdlib>
#include <future>
#include <regex>
#include <set>
#include <thread>

#include "grpcpp/create_channel.h"
#include "render/scene/field_error.h"
#include "tests/integration/security/guarded_server.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds, std::chrono::seconds, std::chrono::steady_clock;
using ::testing::HasSubstr;
using ::testing::Not;

// What a program writes.
std::string OutputOf(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  std::string text;
  char buffer[4096];
  while (const size_t size = fread(buffer, 1, sizeof(buffer), pipe)) text.append(buffer, size);
  pclose(pipe);
  return text;
}

class TlsTest : public ::testing::Test {
 protected:
  void Start(bool asks_for_certificates = false) {
    server_ = std::make_unique<GuardedServer>(
        GuardedServerOptions{.tls = true, .asks_for_certificates = asks_for_certificates});
    token_ = server_->Admit("ana", "editor", "*");
    server_->Start();
  }
  absl::Status ListWith(const std::shared_ptr<grpc::ChannelCredentials>& credentials) {
    return Visitor(server_->address(), credentials, token_)
        .Call("ListScenes", v1::ListScenesRequest());
  }
  // The certificate that a new connection gets, by openssl.
  std::string Fingerprint() {
    return OutputOf("openssl s_client -alpn h2 -connect " + server_->address() +
                    " </dev/null 2>/dev/null | openssl x509 -noout -fingerprint -sha256");
  }

  std::unique_ptr<GuardedServer> server_;
  std::string token_;
};

TEST_F(TlsTest, E05PlaintextToATlsPortIsRefused) {
  Start();
  EXPECT_FALSE(ListWith(grpc::InsecureChannelCredentials()).ok());
  EXPECT_EQ(ListWith(server_->Credentials()), absl::OkStatus());
}

TEST_F(TlsTest, AClientDoesNotTalkToWhomItsAuthorityDoesNotVouchFor) {
  Start();
  const TestAuthority other("Other");
  EXPECT_FALSE(ListWith(grpc::SslCredentials({.pem_root_certs = other.certificate(),
                                              .pem_private_key = "",
                                              .pem_cert_chain = ""}))
                   .ok());
}

TEST_F(TlsTest, E05OnlyClientsWithACertificateOfOurAuthorityGetIn) {
  Start(/*asks_for_certificates=*/true);
  const auto with = [&](const IssuedCertificate& certificate) {
    return ListWith(server_->Credentials(certificate));
  };
  EXPECT_EQ(with(server_->authority().Issue({.common_name = "a"})), absl::OkStatus());
  EXPECT_FALSE(with({}).ok()) << "none";
  EXPECT_FALSE(with(TestAuthority("Studio").Issue({.common_name = "a"})).ok()) << "another's";
  EXPECT_FALSE(with(server_->authority().Issue({.common_name = "a", .valid_days = -1})).ok())
      << "expired";
}

TEST_F(TlsTest, C12Tls12And13WithForwardSecrecyAlone) {
  if (std::system("command -v sslscan >/dev/null") != 0) GTEST_SKIP() << "needs sslscan";
  Start();
  const std::string scan = OutputOf("sslscan --no-colour " + server_->address() + " 2>&1");
  for (const char* off : {"SSLv2", "SSLv3", "TLSv1.0", "TLSv1.1"}) {
    EXPECT_TRUE(std::regex_search(scan, std::regex(std::string(off) + " +disabled"))) << scan;
  }
  for (const char* on : {"TLSv1.2", "TLSv1.3"}) {
    EXPECT_TRUE(std::regex_search(scan, std::regex(std::string(on) + " +enabled"))) << scan;
  }
  EXPECT_THAT(scan, Not(HasSubstr("Compression enabled")));
  // "Accepted  TLSv1.2  128 bits  ECDHE-ECDSA-AES128-GCM-SHA256 …"
  const std::regex line(R"((?:Accepted|Preferred) +(TLSv1\.[0-9]) +\d+ bits +(\S+))");
  std::set<std::string> versions;
  for (auto it = std::sregex_iterator(scan.begin(), scan.end(), line); it != std::sregex_iterator();
       ++it) {
    const std::string version = (*it)[1], cipher = (*it)[2];
    versions.insert(version);
    const bool is_aead =
        cipher.find("GCM") != std::string::npos || cipher.find("CHACHA20") != std::string::npos;
    EXPECT_TRUE(is_aead) << cipher;
    // Those of TLS 1.3 have forward secrecy without saying so.
    EXPECT_TRUE(version == "TLSv1.3" || cipher.starts_with("ECDHE-")) << cipher;
  }
  EXPECT_THAT(versions, ::testing::ElementsAre("TLSv1.2", "TLSv1.3")) << scan;
}

TEST_F(TlsTest, ANewCertificateIsShownAndNoConnectionDropped) {
  Start();
  Visitor ana = server_->Visit(token_);
  ASSERT_EQ(ana.Create("studio"), absl::OkStatus());
  const auto session = ana.Open("Session");
  ASSERT_EQ(ana.Hello(*session, "studio"), absl::OkStatus());
  const std::string before = Fingerprint();
  ASSERT_THAT(before, HasSubstr("Fingerprint="));
  server_->IssueServerCertificate();
  const auto start = steady_clock::now();
  while (Fingerprint() == before && steady_clock::now() - start < seconds(10)) {
  }
  EXPECT_NE(Fingerprint(), before);
  EXPECT_EQ(ListWith(server_->Credentials()), absl::OkStatus());
  EXPECT_EQ(ana.Commit(*session, v1::SceneDelta()), absl::OkStatus());
}

TEST_F(TlsTest, APairThatDoesNotFitIsToldOfAndTheOldOneStays) {
  server_ = std::make_unique<GuardedServer>(GuardedServerOptions{.tls = true});
  token_ = server_->Admit("ana", "editor", "*");
  std::promise<std::string> problem;
  ServerOptions options = server_->Options();
  options.security.on_problem = [&](const std::string& text) { problem.set_value(text); };
  server_->Start(options);
  const std::string before = Fingerprint();
  server_->Replace("server.pem", server_->authority().Issue({.common_name = "p"}).certificate);
  auto told = problem.get_future();
  ASSERT_EQ(told.wait_for(seconds(5)), std::future_status::ready);
  EXPECT_THAT(told.get(), HasSubstr("another certificate"));
  EXPECT_EQ(Fingerprint(), before);
  EXPECT_EQ(ListWith(server_->Credentials()), absl::OkStatus());
}

TEST_F(TlsTest, WhatCannotServeIsAStartUpError) {
  GuardedServer files({.tls = true});
  const auto& ca = files.authority();
  const auto starts_with = [&](const TlsFiles& tls) {
    ServerOptions options = files.Options();
    options.security.tls = tls;
    return PenumbraServer::Start(options).status();
  };
  const std::string pem = files.Path("server.pem"), key = files.Path("server.key");
  files.Replace("other.key", ca.Issue({.common_name = "a"}).key);
  const auto expired = ca.Issue({.common_name = "a", .valid_days = -1});
  files.Replace("old.pem", expired.certificate);
  files.Replace("old.key", expired.key);
  files.Replace("empty", "");
  const std::tuple<TlsFiles, const char*, const char*> cases[] = {
      {{.certificate = pem, .key = "", .client_ca = ""}, "tls-key", "MISSING_FIELD"},
      {{.certificate = "", .key = key, .client_ca = ""}, "tls-certificate", "MISSING_FIELD"},
      {{.certificate = "", .key = "", .client_ca = pem}, "tls-certificate", "MISSING_FIELD"},
      {{.certificate = files.Path("x"), .key = key, .client_ca = ""},
       "tls-certificate",
       "CANNOT_READ"},
      {{.certificate = pem, .key = pem, .client_ca = ""}, "tls-key", "BAD_CERTIFICATE"},
      {{.certificate = key, .key = key, .client_ca = ""}, "tls-certificate", "BAD_CERTIFICATE"},
      {{.certificate = pem, .key = files.Path("other.key"), .client_ca = ""},
       "tls-key",
       "BAD_CERTIFICATE"},
      {{.certificate = files.Path("old.pem"), .key = files.Path("old.key"), .client_ca = ""},
       "tls-certificate",
       "BAD_CERTIFICATE"},
      {{.certificate = pem, .key = key, .client_ca = key}, "tls-client-ca", "BAD_CERTIFICATE"},
  };
  for (const auto& [tls, field, reason] : cases) {
    const auto status = starts_with(tls);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_EQ(ErrorFieldPath(status), field) << status;
    EXPECT_EQ(ErrorReason(status), reason) << status;
  }
}

TEST_F(TlsTest, OtherMachinesNeedIdentitiesToo) {
  GuardedServer files({.tls = true});
  ServerOptions options = files.Options();
  options.listen = "0.0.0.0:0";
  options.security.tls = {};
  EXPECT_EQ(ErrorReason(PenumbraServer::Start(options).status()), "NEEDS_TLS");
  options = files.Options();
  options.listen = "0.0.0.0:0";
  options.security.identities.tokens_file.clear();
  EXPECT_EQ(ErrorReason(PenumbraServer::Start(options).status()), "NEEDS_IDENTITIES");
  options.listen = "127.0.0.1:0";
  options.security.tls.client_ca = files.Path("ca.pem");
  EXPECT_EQ(ErrorFieldPath(PenumbraServer::Start(options).status()), "tls-client-ca");
}

}  // namespace
}  // namespace penumbra::testing
