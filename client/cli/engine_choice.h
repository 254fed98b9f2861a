// Where shadows are computed, as the command line says.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "client/session/client_credentials.h"

namespace penumbra {

struct EngineChoice {
  std::string server;                // "host:port"; empty: in this process
  uint32_t threads = 0;              // of the engine in this process; 0: one a core
  ClientCredentials credentials{};   // shown to the server; ConnectTo adds the token
  std::filesystem::path token_file;  // empty: none
};

}  // namespace penumbra
