// What was asked for of those commands that only tell something.
#pragma once

#include <cstdint>

#include "client/cli/engine_choice.h"

namespace penumbra {

struct TechniquesCommand {
  EngineChoice engine;
  bool json = false;
};

struct InfoCommand {
  EngineChoice engine;
  bool json = false;
};

struct TopCommand {
  EngineChoice engine;
  uint32_t rows = 20;       // of scenes, and of clients
  double interval_s = 1.0;  // between looks
  bool once = false;
  bool json = false;
};

}  // namespace penumbra
