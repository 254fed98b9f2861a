// A server that asks who calls, with a folder of its files, and clients that show what they have.
//
//   GuardedServer server({.tls = true});
//   const std::string token = server.Admit("ana", "editor", "review-*");
//   Visitor ana = server.Visit(token);
//   ana.Call("ListScenes", {…});
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/penumbra_server.h"
#include "server/security/bearer_token.h"
#include "tests/integration/security/visitor.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_authority.h"

namespace penumbra::testing {

struct GuardedServerOptions {
  bool tls = false;
  bool asks_for_certificates = false;
  std::string jwt_keys;  // a key set; empty: none
  std::chrono::milliseconds look_interval{50};
};

class GuardedServer {
 public:
  explicit GuardedServer(const GuardedServerOptions& options = {}) : options_(options) {
    Replace("tokens", "# nobody yet\n");
    Replace("ca.pem", authority_.certificate());
    IssueServerCertificate();
    if (!options.jwt_keys.empty()) Replace("keys.json", options.jwt_keys);
  }
  ~GuardedServer() { server_.reset(); }

  // Puts a file into place in one go.
  void Replace(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / (name + ".new")) << text;
    std::filesystem::rename(folder_ / (name + ".new"), folder_ / name);
  }
  std::string Path(const std::string& name) const { return folder_ / name; }

  // A new token; it counts from the server's start, or some time after.
  std::string Admit(const std::string& name, const std::string& role, const std::string& scenes,
                    const std::string& until = "") {
    const std::string token = MakeBearerToken();
    AddLine(absl::StrCat("token sha256:", HashOfToken(token).hex(), " ", name, " ", role, " ",
                         scenes, " ", until));
    return token;
  }
  void AddLine(const std::string& line) {
    absl::StrAppend(&identities_, line, "\n");
    Replace("tokens", identities_);
  }
  void ForgetAll() {
    identities_.clear();
    Replace("tokens", "# nobody any more\n");
  }

  void IssueServerCertificate() {
    const auto issued = authority_.Issue({.common_name = "p", .alternative_names = kLocalhost});
    Replace("server.pem", issued.certificate);
    Replace("server.key", issued.key);
  }
  const TestAuthority& authority() const { return authority_; }

  ServerOptions Options() const {
    ServerOptions server;
    server.listen = "127.0.0.1:0";
    server.threads = 2;
    server.opens_gl = false;
    SecurityOptions& security = server.security;
    security.look_interval = options_.look_interval;
    security.identities.tokens_file = Path("tokens");
    if (!options_.jwt_keys.empty()) {
      security.identities.jwt_keys_file = Path("keys.json");
      security.identities.jwt = {.issuer = "https://id.example", .audience = "penumbra"};
    }
    if (options_.tls) {
      security.tls = {.certificate = Path("server.pem"), .key = Path("server.key")};
      if (options_.asks_for_certificates) security.tls.client_ca = Path("ca.pem");
    }
    return server;
  }
  void Start() { Start(Options()); }
  void Start(const ServerOptions& options) {
    auto server = PenumbraServer::Start(options);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  void Stop() { server_.reset(); }
  const std::string& address() const { return server_->address(); }

  // Who shows `token`, and a certificate where there is one; both may be empty.
  Visitor Visit(const std::string& token, const IssuedCertificate& certificate = {}) const {
    return Visitor(address(), Credentials(certificate), token);
  }
  std::shared_ptr<grpc::ChannelCredentials> Credentials(
      const IssuedCertificate& certificate = {}) const {
    if (!options_.tls) return grpc::InsecureChannelCredentials();
    return grpc::SslCredentials({.pem_root_certs = authority_.certificate(),
                                 .pem_private_key = certificate.key,
                                 .pem_cert_chain = certificate.certificate});
  }

 private:
  const GuardedServerOptions options_;
  const TestAuthority authority_{"Studio"};
  const TemporaryFolder folder_;
  std::string identities_;
  std::unique_ptr<PenumbraServer> server_;
};

}  // namespace penumbra::testing
