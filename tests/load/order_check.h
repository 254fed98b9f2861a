// Whether what a server acknowledged is what one scene, edited in the server's order, comes to.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/scene/scene.h"
#include "tests/load/load_client.h"

namespace penumbra::load {

struct OrderFindings {
  size_t acknowledged = 0;
  size_t refused = 0;
  size_t unanswered = 0;
  size_t lost = 0;        // acknowledged revisions that the scene does not have
  size_t twice = 0;       // revisions that two commits were acknowledged as
  size_t unknown = 0;     // revisions that nobody was told of
  size_t wrong_hash = 0;  // after a revision the scene is not what the commits up to it make
  std::vector<std::string> errors;  // some of them, as texts

  bool is_clean() const { return lost + twice + unknown + wrong_hash == 0; }
};

// `before` is the scene before the load, `head` the revision and hash that the server has at the
// end, `commits` all of the scene's.
OrderFindings CheckOrder(const Scene& before, Revision head, const std::string& head_hash,
                         const std::vector<const SentCommit*>& commits);

}  // namespace penumbra::load
