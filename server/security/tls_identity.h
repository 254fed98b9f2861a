// The server's certificate and key, read again when their files change.
//
//   auto tls = TlsIdentity::Load({.certificate = "server.pem", .key = "server.key"});
//   builder.AddListeningPort(address, (*tls)->MakeCredentials());
//   if (auto status = (*tls)->Reload(); !status.ok()) …   // now and then; the old pair stays
//
// New connections get the new certificate, those that are open keep theirs. gRPC asks for a
// certificate at each handshake and is handed pairs that fit each other alone: its own watcher of
// files (FileWatcherCertificateProvider) drops the old pair before it looks whether the new one
// does.
//
// TLS 1.2 and 1.3 with forward secrecy and authenticated encryption: gRPC 1.51 allows no other.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "grpcpp/security/server_credentials.h"

namespace penumbra {

// Of PEM files; empty: none.
struct TlsFiles {
  std::string certificate;  // the server's, followed by those between it and its root
  std::string key;
  std::string client_ca;  // who signs clients' certificates; every client must have one then

  bool empty() const { return certificate.empty() && key.empty() && client_ca.empty(); }
};

class TlsIdentity {
 public:
  // Errors  kInvalidArgument, field "tls-certificate", "tls-key" or "tls-client-ca": CANNOT_READ;
  //         BAD_CERTIFICATE: no certificate, no key or one with a passphrase, a key of another
  //         certificate, a certificate that has expired; MISSING_FIELD
  static absl::StatusOr<std::unique_ptr<TlsIdentity>> Load(TlsFiles files);

  // For one listener. Must not be used after this object.
  std::shared_ptr<grpc::ServerCredentials> MakeCredentials();

  // Takes the files over once they have been the same twice and fit each other.
  //
  // Errors  those of Load
  absl::Status Reload();

 private:
  class Credentials;
  struct Texts {
    std::string certificate;
    std::string key;
    std::string client_ca;
    friend bool operator==(const Texts&, const Texts&) = default;
  };

  explicit TlsIdentity(TlsFiles files) : files_(std::move(files)) {}
  absl::StatusOr<Texts> Read() const;
  static absl::Status Check(const Texts& texts);

  const TlsFiles files_;
  Texts seen_;   // when last looked; for Reload's thread alone, as the next
  Texts tried_;  // last taken over, or found not to fit
  std::mutex mutex_;
  Texts current_;  // guarded by mutex_, as the next
  bool is_new_ = true;
};

}  // namespace penumbra
