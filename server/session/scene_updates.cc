#include "server/session/scene_updates.h"

#include <utility>

#include "penumbra/v1/session.pb.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/scene_difference.h"
#include "server/session/wire_message.h"

namespace penumbra {
namespace {

// Revisions, hash and envelope of a SceneUpdate.
constexpr size_t kEnvelopeBytes = 128;

// Whoever is as far as the others asks at once; these are for those who lag a little.
constexpr size_t kMaxEntries = 128;
constexpr size_t kMaxBytes = size_t{16} << 20;

SceneUpdates::Messages Write(const Scene* from, const Scene& to, size_t max_message_bytes) {
  const auto before = from ? nullptr : Scene::Empty(to.id());
  auto pieces =
      ToProtoPieces(Difference(from ? *from : *before, to), max_message_bytes - kEnvelopeBytes);
  SceneUpdates::Messages messages;
  for (auto& piece : pieces) {
    v1::SessionResponse response;
    v1::SceneUpdate& update = *response.mutable_scene_update();
    update.set_from_revision(from ? from->revision() : 0);
    update.set_revision(to.revision());
    update.set_content_hash(ToProto(to.content_hash()));
    update.set_is_snapshot(!from && messages.empty());
    *update.mutable_delta() = std::move(piece);
    update.set_is_continued(messages.size() + 1 < pieces.size());
    messages.push_back(ToBytes(response));
  }
  return messages;
}

}  // namespace

std::shared_ptr<const SceneUpdates::Messages> SceneUpdates::Between(
    const std::shared_ptr<const Scene>& from, const std::shared_ptr<const Scene>& to) {
  {
    std::lock_guard lock(mutex_);
    if (auto known = Find(from.get(), to.get())) return known;
  }
  // Two who come at once both write it, which takes less than making one wait.
  auto messages = std::make_shared<const Messages>(Write(from.get(), *to, max_message_bytes_));
  Entry entry{
      .from = from.get(), .to = to.get(), .held_from = from, .held_to = to, .messages = messages};
  for (const grpc::ByteBuffer& message : *messages) entry.bytes += message.Length();
  Keep(std::move(entry));
  return messages;
}

std::shared_ptr<const SceneUpdates::Messages> SceneUpdates::Find(const Scene* from,
                                                                 const Scene* to) const {
  for (const Entry& entry : newest_) {
    if (entry.from != from || entry.to != to || entry.held_to.expired()) continue;
    if (from == nullptr || !entry.held_from.expired()) return entry.messages;
  }
  return nullptr;
}

void SceneUpdates::Keep(Entry entry) {
  if (entry.bytes > kMaxBytes) return;
  std::lock_guard lock(mutex_);
  bytes_ += entry.bytes;
  newest_.push_front(std::move(entry));
  while (newest_.size() > kMaxEntries || bytes_ > kMaxBytes) {
    bytes_ -= newest_.back().bytes;
    newest_.pop_back();
  }
}

}  // namespace penumbra
