#include "tests/fuzz/targets/archive_books.h"

#include <span>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/blob.h"
#include "render/scene/hashed_text.h"
#include "tests/support/small_archive.h"

namespace penumbra::fuzzing {
namespace {

// A record starts what others may go on with.
constexpr size_t kFirstBytes = 100;

void FillIn(std::string& field, const ContentHash& hash) {
  if (field.empty()) field = ToProto(hash);
}

}  // namespace

void ArchiveBooks::AddHead(const v1::ArchiveHead& head) {
  head_ = head;
  base_revision_ = revision_ = head.base_revision();
}

void ArchiveBooks::AddBlob(const std::string& bytes) {
  const ContentHash hash = HashOfBytes(bytes);
  if (const auto blob = DecodeBlob(std::as_bytes(std::span(bytes))); blob.ok()) blobs_.Add(*blob);
  names_.insert(hash);
  v1::ArchiveRecord& first = records_.emplace_back();
  first.mutable_blob()->set_hash(ToProto(hash));
  first.mutable_blob()->set_size_bytes(bytes.size());
  first.set_data(bytes.substr(0, kFirstBytes));
  if (bytes.size() > kFirstBytes) records_.emplace_back().set_data(bytes.substr(kFirstBytes));
}

void ArchiveBooks::AddBase(const v1::SceneDelta& delta) {
  *records_.emplace_back().mutable_base()->mutable_delta() = delta;
  // Of several in a row all but the last go on.
  if (records_.size() > 1 && records_[records_.size() - 2].has_base()) {
    records_[records_.size() - 2].mutable_base()->set_is_continued(true);
  }
  base_.MergeFrom(delta);
  scene_ = Scene::Empty("studio");
  Apply(base_);
  base_content_ = scene_->content_hash();
}

void ArchiveBooks::Apply(const v1::SceneDelta& delta) {
  const auto read = FromProto(delta, blobs_);
  if (!read.ok()) return;
  if (const auto next = scene_->Apply(*read); next.ok()) scene_ = *next;
}

void ArchiveBooks::AddCommit(const v1::SceneDelta& delta) {
  scene_ = scene_->WithRevision(revision_);
  Apply(delta);
  records_.push_back(testing::RecordOf({.revision = ++revision_,
                                        .content_hash = scene_->content_hash(),
                                        .key = "",
                                        .fingerprint = {},
                                        .author = "tester",
                                        .time_ms = 1'700'000'000'000,
                                        .delta = delta.SerializeAsString()},
                                       chain_));
}

std::vector<v1::ArchiveRecord> ArchiveBooks::Close() {
  v1::ArchiveHead head = head_;
  if (head.format_version() == 0) head.set_format_version(1);
  if (head.scene_id().empty()) head.set_scene_id("studio");
  if (head.incarnation().empty()) head.set_incarnation(std::string(16, 'i'));
  if (head.revision() == 0) head.set_revision(revision_);
  if (head.blob_count() == 0) head.set_blob_count(names_.size());
  FillIn(*head.mutable_base_content_hash(), base_content_);
  FillIn(*head.mutable_base_chain(), HashOfBytes("the chain before"));
  FillIn(*head.mutable_content_hash(), scene_->content_hash());
  FillIn(*head.mutable_chain(), chain_);
  std::vector<v1::ArchiveRecord> records(1);
  *records[0].mutable_head() = head;
  records.insert(records.end(), records_.begin(), records_.end());
  records.emplace_back().mutable_end();
  return records;
}

}  // namespace penumbra::fuzzing
