#include "render/scene/commit_record.h"

namespace penumbra {

ContentHash NextChain(const ContentHash& chain, const CommitRecord& commit,
                      const ContentHash& delta_hash) {
  return HashedText()
      .Add(chain)
      .Add(commit.revision)
      .Add(commit.content_hash)
      .Add(commit.key)
      .Add(commit.fingerprint)
      .Add(commit.author)
      .Add(static_cast<uint64_t>(commit.time_ms))
      .Add(delta_hash)
      .Hash();
}

}  // namespace penumbra
