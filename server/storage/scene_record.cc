#include "server/storage/scene_record.h"

#include <bit>
#include <span>

namespace penumbra {
namespace {

// Fields one after another, each with its length before it, so that no two lists give one text.
class HashedText {
 public:
  HashedText& Add(std::string_view bytes) {
    Add(bytes.size());
    text_.append(bytes);
    return *this;
  }
  HashedText& Add(uint64_t number) {
    for (int shift = 0; shift < 64; shift += 8) text_ += static_cast<char>(number >> shift);
    return *this;
  }
  HashedText& Add(const ContentHash& hash) { return Add(BytesOf(hash)); }
  ContentHash Hash() const { return HashOfBytes(text_); }

 private:
  std::string text_;
};

}  // namespace

ContentHash HashOfBytes(std::string_view bytes) { return Sha256(std::as_bytes(std::span(bytes))); }

std::string_view BytesOf(const ContentHash& hash) {
  return {reinterpret_cast<const char*>(hash.bytes.data()), hash.bytes.size()};
}

ContentHash FirstChain(const SceneIdentity& identity) {
  return HashedText().Add("penumbra scene").Add(identity.scene_id).Add(identity.incarnation).Hash();
}

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

ContentHash HashOf(const SnapshotRecord& snapshot) {
  return HashedText()
      .Add(snapshot.revision)
      .Add(snapshot.content_hash)
      .Add(HashOfBytes(snapshot.body))
      .Hash();
}

ContentHash SealOf(const SceneIdentity& identity, const SceneHead& head) {
  return HashedText()
      .Add(identity.scene_id)
      .Add(identity.incarnation)
      .Add(identity.owner)
      .Add(head.revision)
      .Add(head.chain)
      .Hash();
}

}  // namespace penumbra
