// The file that says who may use the server (--tokens).
//
//   # kind       what they show               name   role    scenes            until (RFC 3339)
//   token        sha256:<64 hex digits>       ana    editor  review-*,studio   2027-01-31T00:00:00Z
//   certificate  cn:render-01                 farm   viewer  *
//
// `penumbrad token` makes a token and its line. A certificate is one that the --tls-client-ca has
// signed, named by "cn:" its subject's common name, or "dns:" or "uri:" an alternative name.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/content_hash.h"
#include "server/security/identity.h"

namespace penumbra {

class IdentityFile {
 public:
  // Errors  kInvalidArgument, field "tokens:LINE": what is wrong with the line; also more than
  //         1,024 identities, and one token or certificate twice
  static absl::StatusOr<IdentityFile> Parse(std::string_view text);

  // Null when there is none. Takes the same time whichever line matches.
  const Identity* FindToken(std::string_view token) const;
  // `names` as "cn:render-01".
  const Identity* FindCertificate(std::span<const std::string> names) const;

  size_t size() const { return tokens_.size() + certificates_.size(); }
  bool has_certificates() const { return !certificates_.empty(); }

 private:
  struct Token {
    ContentHash hash;
    Identity identity;
  };
  struct Certificate {
    std::string name;
    Identity identity;
  };
  absl::Status AddLine(std::string_view line);

  std::vector<Token> tokens_;
  std::vector<Certificate> certificates_;
};

}  // namespace penumbra
