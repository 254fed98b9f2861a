// What clients that mirror a scene are told of it, as messages: found and written once for all who
// are at the same revision.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "grpcpp/support/byte_buffer.h"
#include "render/scene/scene.h"

namespace penumbra {

// Any thread may use it. It keeps the newest messages while the scenes between which they lead are
// kept by others.
class SceneUpdates {
 public:
  // Each one a v1::SessionResponse with a SceneUpdate; copies of a buffer share its bytes.
  using Messages = std::vector<grpc::ByteBuffer>;

  explicit SceneUpdates(size_t max_message_bytes) : max_message_bytes_(max_message_bytes) {}

  // What turns `from` into `to`, or what makes `to` where `from` is null. At least one message.
  std::shared_ptr<const Messages> Between(const std::shared_ptr<const Scene>& from,
                                          const std::shared_ptr<const Scene>& to);

 private:
  struct Entry {
    const Scene* from = nullptr;  // null: nothing
    const Scene* to = nullptr;
    // An address alone may be another scene's by now.
    std::weak_ptr<const Scene> held_from, held_to;
    std::shared_ptr<const Messages> messages;
    size_t bytes = 0;
  };

  std::shared_ptr<const Messages> Find(const Scene* from, const Scene* to) const;
  void Keep(Entry entry);

  const size_t max_message_bytes_;
  mutable std::mutex mutex_;
  std::deque<Entry> newest_;  // the newest first
  size_t bytes_ = 0;
};

}  // namespace penumbra
