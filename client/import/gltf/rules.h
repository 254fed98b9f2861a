// What a glTF 2.0 document must look like where the importer reads it.
#pragma once

#include <span>

#include "client/import/gltf/schema.h"

namespace penumbra::gltf {

// In an order in which each rule may rely on the ones before it.
std::span<const Rule> DocumentRules();

}  // namespace penumbra::gltf
