// Bytes that nobody can guess, for what is named or known by them.
#pragma once

#include <openssl/rand.h>

#include <cstddef>
#include <cstdlib>
#include <string>

namespace penumbra {

// Ends the process where the machine has no randomness: it cannot do TLS either.
inline std::string RandomBytes(size_t count) {
  std::string bytes(count, '\0');
  if (RAND_bytes(reinterpret_cast<unsigned char*>(bytes.data()), static_cast<int>(count)) != 1) {
    std::abort();
  }
  return bytes;
}

}  // namespace penumbra
