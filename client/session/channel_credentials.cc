#include "client/session/channel_credentials.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>
#include <tuple>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status Bad(const char* reason, const char* field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

absl::StatusOr<std::string> ReadPem(const std::string& path, const char* option) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file) text << file.rdbuf();
  if (!file || text.str().empty()) {
    return Bad("CANNOT_READ", option,
               absl::StrCat("found ", path, ": ", errno ? std::strerror(errno) : "empty",
                            ", need a PEM file"));
  }
  return text.str();
}

// By the bytes of the address: a name other than localhost can stand for any machine.
bool IsThisMachine(std::string_view address) {
  if (address.starts_with("unix:")) return true;
  const std::string_view host = address.substr(0, address.rfind(':'));
  if (host == "localhost" || host == "[::1]") return true;
  const bool is_number = std::all_of(host.begin(), host.end(),
                                     [](char c) { return absl::ascii_isdigit(c) || c == '.'; });
  return is_number && host.starts_with("127.");
}

absl::Status CheckToken(const std::string& address, const ClientCredentials& credentials) {
  const std::string& token = credentials.token;
  if (token.empty()) return absl::OkStatus();
  const bool is_header = std::all_of(token.begin(), token.end(),
                                     [](unsigned char c) { return absl::ascii_isgraph(c); });
  if (!is_header) return Bad("BAD_TOKEN", "token", "found blanks or control characters, need none");
  if (credentials.tls || IsThisMachine(address)) return absl::OkStatus();
  return Bad("NEEDS_TLS", "server",
             absl::StrCat("found ", address,
                          " without TLS, need TLS (--tls, --tls-ca) to send a token there"));
}

}  // namespace

absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> MakeChannelCredentials(
    const std::string& address, const ClientCredentials& credentials) {
  if (auto status = CheckToken(address, credentials); !status.ok()) return status;
  if (!credentials.tls) return grpc::InsecureChannelCredentials();
  if (credentials.certificate_file.empty() != credentials.key_file.empty()) {
    return Bad("MISSING_FIELD", credentials.key_file.empty() ? "tls-key" : "tls-certificate",
               "found none, need a certificate and its key");
  }
  grpc::SslCredentialsOptions options;
  for (const auto& [path, option, text] :
       {std::tuple(&credentials.ca_file, "tls-ca", &options.pem_root_certs),
        std::tuple(&credentials.certificate_file, "tls-certificate", &options.pem_cert_chain),
        std::tuple(&credentials.key_file, "tls-key", &options.pem_private_key)}) {
    if (path->empty()) continue;
    auto read = ReadPem(*path, option);
    if (!read.ok()) return read.status();
    *text = *std::move(read);
  }
  return grpc::SslCredentials(options);
}

void ShowToken(const ClientCredentials& credentials, grpc::ClientContext& context) {
  if (!credentials.token.empty())
    context.AddMetadata("authorization", "Bearer " + credentials.token);
}

}  // namespace penumbra
