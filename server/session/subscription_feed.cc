#include "server/session/subscription_feed.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "google/protobuf/io/coded_stream.h"
#include "penumbra/v1/session.pb.h"
#include "proto/convert/status_convert.h"

namespace penumbra {
namespace {

// Tag and length of SessionResponse.artifact_update, and what the first fields of an update can
// take at most, errors apart.
constexpr size_t kEnvelopeBytes = 64;

// The key of a length-delimited field, and its length.
std::string FieldPrefix(int field_number, size_t length) {
  using google::protobuf::io::CodedOutputStream;
  constexpr int kLengthDelimited = 2;
  uint8_t bytes[16];
  uint8_t* end = CodedOutputStream::WriteVarint32ToArray(
      static_cast<uint32_t>(field_number) << 3 | kLengthDelimited, bytes);
  end = CodedOutputStream::WriteVarint64ToArray(length, end);
  return std::string(bytes, end);
}

}  // namespace

SubscriptionFeed::SubscriptionFeed(uint64_t subscription_id, std::shared_ptr<ArtifactStream> stream,
                                   uint32_t credit, const ServerLimits& limits)
    : id_(subscription_id),
      stream_(std::move(stream)),
      max_credit_(limits.max_credit),
      max_message_bytes_(limits.max_message_bytes),
      credit_(std::min(credit, limits.max_credit)) {}

void SubscriptionFeed::AddCredit(uint32_t updates) {
  credit_ = static_cast<uint32_t>(std::min<uint64_t>(uint64_t{credit_} + updates, max_credit_));
}

void SubscriptionFeed::Acknowledge(uint64_t update_sequence) {
  if (update_sequence <= held_sequence_) acknowledged_ = std::max(acknowledged_, update_sequence);
}

bool SubscriptionFeed::HasMessage() const {
  return in_update() || (credit_ > 0 && stream_->Latest().number > sent_number_);
}

void SubscriptionFeed::BeginUpdate() {
  sending_ = stream_->Latest();
  // What came before the subscription was not for it.
  skipped_ = sent_number_ == 0 ? 0 : sending_.number - sent_number_ - 1;
  all_skipped_ += skipped_;
  sent_number_ = sending_.number;
  --credit_;
  sends_artifact_ =
      sending_.status.ok() && sending_.artifact && sending_.artifact->sequence != held_sequence_;
  is_first_message_ = true;
  base_ = acknowledged_;
  next_tile_ = 0;
}

std::optional<uint64_t> SubscriptionFeed::TakeSkipped(std::chrono::steady_clock::time_point now) {
  constexpr std::chrono::seconds kInterval{1};
  if (in_update() || now - told_at_ < kInterval) return std::nullopt;
  // Those that the update which is about to begin takes the place of are among them.
  const uint64_t passed_over = sent_number_ == 0 ? 0 : stream_->Latest().number - sent_number_ - 1;
  if (all_skipped_ + passed_over == told_skipped_) return std::nullopt;
  told_skipped_ = all_skipped_ + passed_over;
  told_at_ = now;
  return told_skipped_;
}

SubscriptionFeed::Message SubscriptionFeed::NextMessage() {
  if (!in_update()) BeginUpdate();
  v1::ArtifactUpdate fields;
  fields.set_subscription_id(id_);
  SharedSlices shared;
  if (std::exchange(is_first_message_, false)) BeginMessages(fields, shared);
  const bool is_last = !sends_artifact_ || AddTiles(shared);
  if (is_last && sends_artifact_) held_sequence_ = sending_.artifact->sequence;
  fields.set_update_sequence(sends_artifact_ ? sending_.artifact->sequence : held_sequence_);
  fields.set_end_of_update(is_last);
  if (is_last) sending_ = {};
  const std::string own = fields.SerializeAsString();
  shared.slices[0] = grpc::Slice(
      FieldPrefix(v1::SessionResponse::kArtifactUpdateFieldNumber, own.size() + shared.bytes) +
      own);
  return {grpc::ByteBuffer(shared.slices.data(), shared.slices.size()), is_last,
          is_last ? skipped_ : 0};
}

void SubscriptionFeed::BeginMessages(v1::ArtifactUpdate& fields, SharedSlices& shared) const {
  fields.set_revision(sending_.revision);
  if (!sending_.status.ok()) *fields.mutable_error() = ToProto(sending_.status);
  if (!sends_artifact_) return;
  fields.set_base_sequence(base_);
  shared.Add(sending_.artifact->header);
  if (sending_.artifact->light_samples_changed_at > base_) {
    shared.Add(sending_.artifact->light_samples);
  }
}

bool SubscriptionFeed::AddTiles(SharedSlices& shared) {
  const auto& tiles = sending_.artifact->tiles;
  for (; next_tile_ < tiles.size(); ++next_tile_) {
    const EncodedTile& tile = tiles[next_tile_];
    if (tile.changed_at <= base_) continue;
    // One at least, so that there is an end.
    const bool fits = shared.bytes + tile.bytes.size() + kEnvelopeBytes <= max_message_bytes_;
    if (!fits && shared.bytes > 0) return false;
    shared.Add(tile.bytes);
  }
  return true;
}

}  // namespace penumbra
