// A certificate authority of a test's own.
//
//   TestAuthority studio("Studio");
//   const auto server = studio.Issue({.common_name = "a", .alternative_names = kLocalhost});
#pragma once

#include <memory>
#include <string>

struct evp_pkey_st;
struct x509_st;

namespace penumbra::testing {

inline constexpr char kLocalhost[] = "DNS:localhost,IP:127.0.0.1";

struct CertificateRequest {
  std::string common_name;
  std::string alternative_names = "";  // as OpenSSL writes them; empty: none
  int valid_days = 1;                  // negative: it has expired
};

// In PEM.
struct IssuedCertificate {
  std::string certificate;
  std::string key;
};

class TestAuthority {
 public:
  explicit TestAuthority(const std::string& name);

  std::string certificate() const;
  IssuedCertificate Issue(const CertificateRequest& request) const;

 private:
  std::shared_ptr<evp_pkey_st> key_;
  std::shared_ptr<x509_st> certificate_;
};

}  // namespace penumbra::testing
