// Whether a write-ahead log of SQLite's still has all that was committed to it.
//
// SQLite reads a log up to the first frame whose checksum is wrong, and takes the rest for what a
// crash left half written. That is right for the last transaction; a damaged frame before that one
// would silently take back what was acknowledged. The log is read as section 4 of
// sqlite.org/fileformat2.html describes it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "absl/status/statusor.h"

namespace penumbra {

enum class WalState {
  kWhole,     // everything in it can be read, or there is no log
  kTornTail,  // one transaction at its end is incomplete, as after a loss of power
  kDamaged,   // a transaction that others follow is incomplete, or the header is
};

WalState CheckWal(std::span<const std::byte> log);

// The same of a file; there need be none. Errors  kUnavailable STORAGE_FAILED
absl::StatusOr<WalState> CheckWalFile(const std::string& path);

}  // namespace penumbra
