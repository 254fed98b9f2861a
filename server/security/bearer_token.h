// Bearer tokens that penumbrad makes: 256 random bits, of which it keeps the SHA-256 alone.
//
//   const std::string token = MakeBearerToken();  // "penumbra_" and 43 characters
//   HashOfToken(token).hex();                     // what the file of identities holds
//
// The hash is neither salted nor slow. Both protect secrets that people think up, for which whoever
// steals the file can try a dictionary; against 256 random bits there is nothing to try, salted or
// not, and a fast hash lets every call be checked anew. That is why nothing but tokens of this form
// is accepted: a hash of "password" in the file opens nothing.
#pragma once

#include <string>
#include <string_view>

#include "render/scene/content_hash.h"

namespace penumbra {

std::string MakeBearerToken();
bool IsBearerToken(std::string_view text);
ContentHash HashOfToken(std::string_view token);

}  // namespace penumbra
