// Checks a JSON document against a table of rules, so that what reads it afterwards may trust it.
//
//   const Rule rules[] = {{"nodes[].mesh", Kind::kIndex, .of = "meshes"}};
//   absl::Status status = CheckSchema(document, rules);  // "nodes[4].mesh: found 9, need < 3"
#pragma once

#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>

#include "absl/status/status.h"

namespace penumbra::gltf {

enum class Kind {
  kObject,
  kUnsigned,  // an integer in [min, max]; one written as 3.0 is rewritten as 3
  kIndex,     // an unsigned integer below the length of the array at `of`
  kNumber,    // in [min, max]
  kNumbers,   // an array of `count` numbers, or of any length when 0
  kBool,
  kString,  // one of `of`, separated by blanks, when that is not empty
};

// What must be at `path`, wherever that leads. "a.b[]" stands for each element of the array a.b and
// "a.b{}" for each value of the object a.b; both make a.b itself an array or object. Where an
// object on the way is absent the rule says nothing.
struct Rule {
  std::string_view path;
  Kind kind = Kind::kObject;
  std::string_view of = {};
  double min = 0.0;
  double max = std::numeric_limits<double>::infinity();
  int count = 0;
  bool required = false;  // the last part must be there when what holds it is
};

// Errors  kInvalidArgument, reason SCHEMA; the path names the elements
absl::Status CheckSchema(nlohmann::json& document, std::span<const Rule> rules);

struct JsonSize {
  size_t depth = 0;   // the deepest nesting of brackets
  size_t values = 0;  // about how many there are: brackets that open, and commas
};

// How large JSON text is, found without building anything.
JsonSize MeasureJson(std::string_view json);

}  // namespace penumbra::gltf
