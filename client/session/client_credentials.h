// What a client shows to a server, and how it knows the server.
//
//   auto credentials = ClientCredentials{.token = token, .tls = true, .ca_file = "studio-ca.pem"};
#pragma once

#include <string>

namespace penumbra {

struct ClientCredentials {
  // A bearer token; empty: none. It is sent over TLS, or to this machine, and nowhere else.
  std::string token;
  // Encrypted, with a server whose certificate is for the host of the address.
  bool tls = false;
  // Who may have signed that, in PEM; empty: those whom the system trusts.
  std::string ca_file;
  // The client's own certificate and its key, in PEM, for servers that ask for one; empty: none.
  std::string certificate_file;
  std::string key_file;
};

}  // namespace penumbra
