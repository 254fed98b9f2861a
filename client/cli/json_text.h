// JSON as it is printed.
//
//   console.out << JsonText(json) << std::endl;
#pragma once

#include <string>

namespace penumbra {

// Names of files may be any bytes, and JSON is UTF-8: what is none becomes U+FFFD.
template <typename Json>
std::string JsonText(const Json& json, int indent = 2) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace penumbra
