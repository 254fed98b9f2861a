#include "tests/support/test_authority.h"

#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>

#include <cstdint>
#include <cstdlib>

namespace penumbra::testing {
namespace {

constexpr long kSecondsADay = 86'400;

template <typename Write>
std::string Pem(Write write) {
  BIO* out = BIO_new(BIO_s_mem());
  write(out);
  char* text = nullptr;
  const long size = BIO_get_mem_data(out, &text);
  std::string pem(text, static_cast<size_t>(size));
  BIO_free(out);
  return pem;
}

std::string PemOf(X509* certificate) {
  return Pem([&](BIO* out) { PEM_write_bio_X509(out, certificate); });
}

void Extend(X509* certificate, X509* issuer, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str());
  if (!extension || X509_add_ext(certificate, extension, -1) != 1) std::abort();
  X509_EXTENSION_free(extension);
}

X509* Unsigned(EVP_PKEY* key, const CertificateRequest& request) {
  X509* certificate = X509_new();
  X509_set_version(certificate, 2);
  uint32_t serial = 0;
  RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof(serial));
  ASN1_INTEGER_set_uint64(X509_get_serialNumber(certificate), serial + uint64_t{1});
  X509_gmtime_adj(X509_getm_notBefore(certificate), -2 * kSecondsADay);
  X509_gmtime_adj(X509_getm_notAfter(certificate), request.valid_days * kSecondsADay);
  X509_set_pubkey(certificate, key);
  X509_NAME_add_entry_by_txt(X509_get_subject_name(certificate), "CN", MBSTRING_UTF8,
                             reinterpret_cast<const unsigned char*>(request.common_name.c_str()),
                             -1, -1, 0);
  return certificate;
}

}  // namespace

TestAuthority::TestAuthority(const std::string& name)
    : key_(EVP_EC_gen("P-256"), EVP_PKEY_free),
      certificate_(Unsigned(key_.get(), {.common_name = name}), X509_free) {
  X509* own = certificate_.get();
  X509_set_issuer_name(own, X509_get_subject_name(own));
  Extend(own, own, NID_basic_constraints, "critical,CA:TRUE");
  Extend(own, own, NID_key_usage, "critical,keyCertSign");
  X509_sign(own, key_.get(), EVP_sha256());
}

std::string TestAuthority::certificate() const { return PemOf(certificate_.get()); }

IssuedCertificate TestAuthority::Issue(const CertificateRequest& request) const {
  EVP_PKEY* key = EVP_EC_gen("P-256");
  X509* issued = Unsigned(key, request);
  X509_set_issuer_name(issued, X509_get_subject_name(certificate_.get()));
  Extend(issued, certificate_.get(), NID_ext_key_usage, "serverAuth,clientAuth");
  if (!request.alternative_names.empty()) {
    Extend(issued, certificate_.get(), NID_subject_alt_name, request.alternative_names);
  }
  X509_sign(issued, key_.get(), EVP_sha256());
  IssuedCertificate pems = {.certificate = PemOf(issued), .key = Pem([&](BIO* out) {
                                                            PEM_write_bio_PrivateKey(
                                                                out, key, nullptr, nullptr, 0,
                                                                nullptr, nullptr);
                                                          })};
  X509_free(issued);
  EVP_PKEY_free(key);
  return pems;
}

}  // namespace penumbra::testing
