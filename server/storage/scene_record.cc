#include "server/storage/scene_record.h"

#include "render/scene/hashed_text.h"

namespace penumbra {

ContentHash FirstChain(const SceneIdentity& identity) {
  return HashedText().Add("penumbra scene").Add(identity.scene_id).Add(identity.incarnation).Hash();
}

ContentHash HashOf(const SnapshotRecord& snapshot) {
  return HashedText()
      .Add(snapshot.revision)
      .Add(snapshot.content_hash)
      .Add(HashOfBytes(snapshot.body))
      .Hash();
}

ContentHash SealOf(const SceneIdentity& identity, const SceneHead& head,
                   const std::string& journal) {
  HashedText text;
  text.Add(identity.scene_id)
      .Add(identity.incarnation)
      .Add(identity.owner)
      .Add(head.revision)
      .Add(head.chain);
  if (!journal.empty()) text.Add(journal);  // files of format 1 name none
  return text.Hash();
}

}  // namespace penumbra
