// What a command shows to its server.
#include "client/cli/grammar.h"

namespace penumbra {

void Grammar::AddCredentials(CLI::App* app, EngineChoice& engine) {
  app->add_option("--token-file", engine.token_file,
                  "Show the token in this file (default: that of PENUMBRA_TOKEN, if it is set)")
      ->type_name("FILE");
  app->add_flag("--tls", engine.credentials.tls,
                "Encrypt, with a server that the system's certificate authorities vouch for");
  app->add_option("--tls-ca", engine.credentials.ca_file, "Or that these do, in PEM")
      ->type_name("FILE");
  app->add_option("--tls-certificate", engine.credentials.certificate_file,
                  "Show this certificate, in PEM")
      ->type_name("FILE");
  app->add_option("--tls-key", engine.credentials.key_file, "With this key, in PEM")
      ->type_name("FILE");
}

}  // namespace penumbra
