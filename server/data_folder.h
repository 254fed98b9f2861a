// Where penumbrad keeps scenes when nobody says.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "server/option_sources.h"

namespace penumbra {

// The first that there is of
//   STATE_DIRECTORY              systemd's, of a unit with StateDirectory=; the first of several
//   $XDG_DATA_HOME/penumbra      where that is an absolute path
//   $HOME/.local/share/penumbra
// and empty where there is none.
std::string DefaultDataFolder(const Environment& environment);

// Makes the folders that `folder` lies in, for this user alone, where they are missing.
// Errors  kUnavailable DATA_DIR: they cannot be made
absl::Status MakeFoldersAround(const std::string& folder);

// `is_given`  somebody named the folder
// Errors  kInvalidArgument DATA_DIR: a given one and ephemeral too, or neither of both
absl::Status CheckDataFolder(const std::string& data_dir, bool is_given, bool ephemeral);

}  // namespace penumbra
