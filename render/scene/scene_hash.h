// What a scene's objects count in its content hash.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "render/scene/area_light.h"
#include "render/scene/content_hash.h"
#include "render/scene/instance.h"
#include "render/scene/receiver.h"

namespace penumbra {

// Equal for equal objects, −0 and 0 being one.
ContentHash HashOf(const Instance& instance);
ContentHash HashOf(const AreaLight& light);
ContentHash HashOf(const Receiver& receiver);

using InstanceTable = std::map<std::string, std::shared_ptr<const Instance>, std::less<>>;

// Of all that light meets: equal for the same instances, whatever their colours. One hash of them
// all in their order, so that nobody can make up another table of the same hash.
//
// Cost  O(N), 0.1 µs an instance
ContentHash HashOfSurfaces(const InstanceTable& instances);

}  // namespace penumbra
