// A delta from the empty scene, cut into pieces that fit into messages.
#pragma once

#include <cstddef>
#include <vector>

#include "penumbra/v1/archive.pb.h"

namespace penumbra {

// The base of an archive: at least one piece, each of at most `max_bytes` or of one object, all but
// the last with is_continued.
std::vector<v1::ArchiveBase> BasePieces(v1::SceneDelta whole, size_t max_bytes);

}  // namespace penumbra
