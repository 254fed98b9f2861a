// `penumbrad token`: makes a bearer token, and the line of the identities' file that admits it.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace penumbra {

struct TokenRequest {
  std::string name;
  std::string role;
  std::string scenes = "*";
  int days = 0;        // 0: for good
  std::string append;  // to this file; empty: to none
};

// Adds the command, which runs while the command line is parsed and ends the parsing: by
// CLI::Success once it is done, by another CLI::ParseError where it cannot be. The token goes to
// standard output, the line to standard error or to a file.
void AddTokenCommand(CLI::App& app, TokenRequest& request);

}  // namespace penumbra
