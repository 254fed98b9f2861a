#include "server/results/stored_results.h"

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/artifact_assembler.h"
#include "render/artifact/artifact_size.h"
#include "render/scene/hashed_text.h"

namespace penumbra {
namespace {

// For the last ones, when the server ends.
constexpr std::chrono::seconds kLastWrites{1};

void Append(const grpc::Slice& slice, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
}

// The fields of one message, strung together.
std::string MessageOf(const EncodedArtifact& encoded) {
  v1::ArtifactUpdate rest;
  rest.set_update_sequence(encoded.sequence);
  rest.set_revision(encoded.artifact->header.revision);
  rest.set_end_of_update(true);
  std::string bytes = rest.SerializeAsString();
  Append(encoded.header, bytes);
  Append(encoded.light_samples, bytes);
  for (const EncodedTile& tile : encoded.tiles) Append(tile.bytes, bytes);
  return bytes;
}

// Null: there is none in them.
std::shared_ptr<const Artifact> ArtifactIn(const std::string& bytes, const SceneLimits& limits) {
  v1::ArtifactUpdate message;
  if (!message.ParseFromString(bytes)) return nullptr;
  message.mutable_header()->clear_timings_ms();  // nothing is computed
  ArtifactAssembler assembler(limits);
  const auto update = assembler.Add(message);
  return update.ok() && update->has_value() ? (*update)->artifact : nullptr;
}

}  // namespace

absl::StatusOr<std::unique_ptr<StoredResults>> StoredResults::Open(
    const StoredResultsOptions& options, Logger& logger) {
  auto files = ResultFiles::Open(options.folder, options.max_bytes);
  if (!files.ok()) return files.status();
  return std::unique_ptr<StoredResults>(new StoredResults(options, *std::move(files), logger));
}

StoredResults::StoredResults(const StoredResultsOptions& options,
                             std::unique_ptr<ResultFiles> files, Logger& logger)
    : options_(options),
      origin_(HashOfBytes(options.origin)),
      files_(std::move(files)),
      logger_(logger),
      writer_([this] { WriteDue(); }) {}

StoredResults::~StoredResults() {
  {
    std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  changed_.notify_all();
  writer_.join();
}

ContentHash StoredResults::NameOf(const ContentHash& key) const {
  return HashedText().Add(origin_).Add(key).Hash();
}

std::shared_ptr<const Artifact> StoredResults::Load(const ContentHash& key) {
  // One at a time: a disk that hangs is to hold up one job and no more.
  const std::unique_lock loading(loading_, std::try_to_lock);
  if (!loading.owns_lock()) return nullptr;
  const ContentHash name = NameOf(key);
  const auto bytes = files_->Read(name);
  if (!bytes) return nullptr;
  auto artifact = ArtifactIn(*bytes, options_.limits);
  if (!artifact) files_->Remove(name);  // of other limits, perhaps
  return artifact;
}

void StoredResults::Save(const std::string& slot, const ContentHash& key,
                         std::shared_ptr<const Artifact> artifact) {
  const ContentHash name = NameOf(key);
  const size_t bytes = BytesOf(*artifact);
  std::lock_guard lock(mutex_);
  if (const auto found = by_slot_.find(slot); found != by_slot_.end()) Drop(found->second);
  if (bytes > kMaxWaitingBytes || files_->Contains(name)) return;
  while (waiting_bytes_ + bytes > kMaxWaitingBytes) Drop(waiting_.begin());
  waiting_.push_back({slot, name, std::move(artifact), bytes, Clock::now() + options_.rest});
  by_slot_[slot] = std::prev(waiting_.end());
  waiting_bytes_ += bytes;
  changed_.notify_all();
}

void StoredResults::Drop(std::list<Waiting>::iterator waiting) {
  waiting_bytes_ -= waiting->bytes;
  by_slot_.erase(waiting->slot);
  waiting_.erase(waiting);
}

void StoredResults::WriteDue() {
  std::unique_lock lock(mutex_);
  Clock::time_point end = Clock::time_point::max();
  while (true) {
    if (is_ending_) end = std::min(end, Clock::now() + kLastWrites);
    if (is_ending_ && (waiting_.empty() || Clock::now() >= end)) return;
    if (waiting_.empty()) {
      changed_.wait(lock);
      continue;
    }
    // A copy: whoever waits in front may go meanwhile.
    const Clock::time_point due = waiting_.front().due;
    if (!is_ending_ && Clock::now() < due) {
      changed_.wait_until(lock, due);
      continue;
    }
    std::optional<Waiting> result = waiting_.front();
    Drop(waiting_.begin());
    lock.unlock();
    Write(*result);
    result.reset();
    lock.lock();
  }
}

void StoredResults::Write(const Waiting& result) {
  absl::Status status;
  try {
    const auto encoded = encoder_.Encode(nullptr, result.artifact, /*sequence=*/1);
    status = files_->Write(result.name, MessageOf(*encoded));
  } catch (const std::exception& error) {
    status = absl::ResourceExhaustedError(error.what());
  }
  // Nothing is lost but time; told once, until it goes well again.
  if (!status.ok() && !std::exchange(is_failing_, true)) {
    logger_.Warning("results_not_stored", {{"error", std::string(status.message())}});
  }
  if (status.ok()) is_failing_ = false;
}

}  // namespace penumbra
