// One subscription of one session: which update is due, and its messages.
//
// It keeps no queue. What is due is found by comparing the stream's newest state with what was sent
// last, so a client that is slow, or has given no credit, skips what came in between and then gets
// the newest; it holds on to one artifact at most.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/slice.h"
#include "penumbra/v1/artifact.pb.h"
#include "server/limits.h"
#include "server/session/artifact_stream.h"

namespace penumbra {

class SubscriptionFeed {
 public:
  SubscriptionFeed(uint64_t subscription_id, std::shared_ptr<ArtifactStream> stream,
                   uint32_t credit, const ServerLimits& limits);

  uint64_t id() const { return id_; }
  ArtifactStream& stream() { return *stream_; }

  void AddCredit(uint32_t updates);
  // What the client holds whole. Numbers that were never sent are ignored.
  void Acknowledge(uint64_t update_sequence);

  // Whether an update is under way, of which the next message can follow.
  bool in_update() const { return sending_.number != 0; }
  // Whether there is a message to send now.
  bool HasMessage() const;

  // States that were passed over since the first update, where somebody is to be told of them now:
  // not more often than once a second.
  std::optional<uint64_t> TakeSkipped(std::chrono::steady_clock::time_point now);

  struct Message {
    grpc::ByteBuffer bytes;  // a v1::SessionResponse
    bool ends_update = false;
    uint64_t skipped_updates = 0;  // with the end: how many this one took the place of
  };
  // Only where HasMessage().
  Message NextMessage();

 private:
  // A message in the making: a place for what is this subscription's own, then what all share.
  struct SharedSlices {
    std::vector<grpc::Slice> slices = std::vector<grpc::Slice>(1);
    size_t bytes = 0;

    void Add(const grpc::Slice& slice) {
      slices.push_back(slice);
      bytes += slice.size();
    }
  };

  void BeginUpdate();
  void BeginMessages(v1::ArtifactUpdate& fields, SharedSlices& shared) const;
  // Whether all the rest fitted in.
  bool AddTiles(SharedSlices& shared);

  const uint64_t id_;
  const std::shared_ptr<ArtifactStream> stream_;
  const uint32_t max_credit_;
  const size_t max_message_bytes_;
  uint32_t credit_;
  uint64_t sent_number_ = 0;   // StreamState::number of the update last begun
  uint64_t all_skipped_ = 0;   // states that were never sent
  uint64_t told_skipped_ = 0;  // of which the client has been told
  std::chrono::steady_clock::time_point told_at_{};
  uint64_t held_sequence_ = 0;  // of the artifact last sent whole; the client holds it or soon will
  uint64_t acknowledged_ = 0;   // of the newest artifact that the client says it holds

  // The update under way; its number is 0 where there is none.
  StreamState sending_;
  bool sends_artifact_ = false;
  bool is_first_message_ = false;
  uint64_t skipped_ = 0;
  uint64_t base_ = 0;
  size_t next_tile_ = 0;
};

}  // namespace penumbra
