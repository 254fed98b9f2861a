// Archives that somebody makes up and keeps the books of: whatever is in them, their hashes are
// right, so that a reader has to look at the content.
//
//   ArchiveBooks books;
//   books.AddHead(head);      // what is absent of it is filled in
//   books.AddBlob(bytes);
//   books.AddCommit(delta);
//   std::vector<v1::ArchiveRecord> records = books.Close();
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "penumbra/v1/archive.pb.h"
#include "render/scene/commit_record.h"
#include "render/scene/scene.h"
#include "tests/fuzz/targets/known_blobs.h"

namespace penumbra::fuzzing {

class ArchiveBooks {
 public:
  void AddHead(const v1::ArchiveHead& head);
  void AddBlob(const std::string& bytes);
  void AddBase(const v1::SceneDelta& delta);
  void AddCommit(const v1::SceneDelta& delta);
  // As it is, whatever that does to the order.
  void Add(const v1::ArchiveRecord& record) { records_.push_back(record); }

  std::vector<v1::ArchiveRecord> Close();

 private:
  // What `delta` makes of the scene, where it makes one.
  void Apply(const v1::SceneDelta& delta);

  v1::ArchiveHead head_;
  std::vector<v1::ArchiveRecord> records_;  // after the head
  std::set<ContentHash> names_;             // of blobs
  KnownBlobs blobs_;
  v1::SceneDelta base_;  // the pieces so far
  std::shared_ptr<const Scene> scene_ = Scene::Empty("studio");
  ContentHash base_content_;
  ContentHash chain_ = HashOfBytes("the chain before");
  Revision base_revision_ = 0;
  Revision revision_ = 0;
};

}  // namespace penumbra::fuzzing
