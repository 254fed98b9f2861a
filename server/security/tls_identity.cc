#include "server/security/tls_identity.h"

#include <grpc/grpc.h>
#include <grpc/grpc_security.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <tuple>
#include <utility>

#include "render/scene/field_error.h"
#include "server/security/small_file.h"

namespace penumbra {
namespace {

template <typename T, auto kFree>
struct Freed {
  void operator()(T* object) const { kFree(object); }
};
using Bio = std::unique_ptr<BIO, Freed<BIO, BIO_free>>;
using Certificate = std::unique_ptr<X509, Freed<X509, X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY, EVP_PKEY_free>>;

Bio Open(const std::string& text) {
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

Certificate FirstCertificate(const std::string& text) {
  return Certificate(PEM_read_bio_X509(Open(text).get(), nullptr, nullptr, nullptr));
}

// Without a passphrase: nobody is there to type one.
Key ReadKey(const std::string& text) {
  const auto no_passphrase = [](char*, int, int, void*) { return -1; };
  return Key(PEM_read_bio_PrivateKey(Open(text).get(), nullptr, no_passphrase, nullptr));
}

absl::Status Bad(const char* field, const char* text) {
  ERR_clear_error();  // of OpenSSL's queue, which gRPC reads too
  return FieldError(absl::StatusCode::kInvalidArgument, "BAD_CERTIFICATE", field, text);
}

}  // namespace

// What ServerBuilder takes, around gRPC's C interface: its C++ one has no certificates that change.
class TlsIdentity::Credentials final : public grpc::ServerCredentials {
 public:
  explicit Credentials(TlsIdentity& identity) {
    const auto request = identity.files_.client_ca.empty()
                             ? GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE
                             : GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY;
    credentials_ = grpc_ssl_server_credentials_create_with_options(
        grpc_ssl_server_credentials_create_options_using_config_fetcher(request, &Fetch,
                                                                        &identity));
  }
  ~Credentials() override { grpc_server_credentials_release(credentials_); }

  // The guard reads headers itself (call_guard.h).
  void SetAuthMetadataProcessor(const std::shared_ptr<grpc::AuthMetadataProcessor>&) override {}

 private:
  int AddPortToServer(const std::string& address, grpc_server* server) override {
    return grpc_server_add_http2_port(server, address.c_str(), credentials_);
  }

  // gRPC asks at each handshake, one at a time.
  static grpc_ssl_certificate_config_reload_status Fetch(
      void* data, grpc_ssl_server_certificate_config** config) {
    auto& identity = *static_cast<TlsIdentity*>(data);
    std::lock_guard lock(identity.mutex_);
    if (!identity.is_new_) return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_UNCHANGED;
    identity.is_new_ = false;
    const Texts& texts = identity.current_;
    const grpc_ssl_pem_key_cert_pair pair = {texts.key.c_str(), texts.certificate.c_str()};
    // gRPC 1.51 aborts where a fetched pair has no roots. Those of a server that asks for no
    // certificate are looked at by nobody.
    const std::string& roots = texts.client_ca.empty() ? texts.certificate : texts.client_ca;
    *config = grpc_ssl_server_certificate_config_create(roots.c_str(), &pair, 1);
    return GRPC_SSL_CERTIFICATE_CONFIG_RELOAD_NEW;
  }

  grpc_server_credentials* credentials_ = nullptr;
};

absl::StatusOr<std::unique_ptr<TlsIdentity>> TlsIdentity::Load(TlsFiles files) {
  for (const auto& [path, option] :
       {std::pair(&files.certificate, "tls-certificate"), std::pair(&files.key, "tls-key")}) {
    if (!path->empty()) continue;
    return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", option,
                      "found none, need both --tls-certificate and --tls-key");
  }
  std::unique_ptr<TlsIdentity> identity(new TlsIdentity(std::move(files)));
  auto texts = identity->Read();
  if (!texts.ok()) return texts.status();
  if (auto status = Check(*texts); !status.ok()) return status;
  identity->seen_ = identity->tried_ = identity->current_ = *std::move(texts);
  return identity;
}

std::shared_ptr<grpc::ServerCredentials> TlsIdentity::MakeCredentials() {
  return std::make_shared<Credentials>(*this);
}

absl::StatusOr<TlsIdentity::Texts> TlsIdentity::Read() const {
  Texts texts;
  for (const auto& [path, option, text] :
       {std::tuple(&files_.certificate, "tls-certificate", &texts.certificate),
        std::tuple(&files_.key, "tls-key", &texts.key),
        std::tuple(&files_.client_ca, "tls-client-ca", &texts.client_ca)}) {
    if (path->empty()) continue;
    auto read = ReadSmallFile(*path, option);
    if (!read.ok()) return read.status();
    *text = *std::move(read);
  }
  return texts;
}

absl::Status TlsIdentity::Check(const Texts& texts) {
  const Certificate certificate = FirstCertificate(texts.certificate);
  if (!certificate) return Bad("tls-certificate", "found no certificate, need one in PEM");
  const Key key = ReadKey(texts.key);
  if (!key) return Bad("tls-key", "found no private key without a passphrase, need one in PEM");
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    return Bad("tls-key", "found the key of another certificate, need that of --tls-certificate");
  }
  if (X509_cmp_current_time(X509_get0_notAfter(certificate.get())) <= 0) {
    return Bad("tls-certificate", "found one that has expired, need one that is valid");
  }
  if (!texts.client_ca.empty() && !FirstCertificate(texts.client_ca)) {
    return Bad("tls-client-ca", "found no certificate, need one in PEM");
  }
  return absl::OkStatus();
}

absl::Status TlsIdentity::Reload() {
  auto texts = Read();
  if (!texts.ok()) return texts.status();
  const bool has_settled = *texts == seen_;
  seen_ = *texts;
  if (!has_settled || *texts == tried_) return absl::OkStatus();
  tried_ = *texts;
  if (auto status = Check(*texts); !status.ok()) return status;
  std::lock_guard lock(mutex_);
  current_ = *std::move(texts);
  is_new_ = true;
  return absl::OkStatus();
}

}  // namespace penumbra
