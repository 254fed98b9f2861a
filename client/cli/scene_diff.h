// What differs between two scenes, object by object and field by field.
//
//   for (const ObjectChange& change : DiffScenes(*before, *after)) …
#pragma once

#include <string>
#include <vector>

#include "render/scene/scene.h"

namespace penumbra {

// As the protocol names fields: "rectangle.radiance". A field that one of them lacks is "".
struct FieldChange {
  std::string field;
  std::string from;
  std::string to;
};

struct ObjectChange {
  enum class Kind { kAdded, kRemoved, kChanged };
  Kind kind = Kind::kChanged;
  std::string object;  // "instance", "light" or "receiver"
  std::string id;
  std::vector<FieldChange> fields;  // of one that has changed
};

// By kinds of objects, and within them in the order of ids. None: the scenes are equal.
std::vector<ObjectChange> DiffScenes(const Scene& from, const Scene& to);

}  // namespace penumbra
