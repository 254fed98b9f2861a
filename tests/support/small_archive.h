// The records of an archive: a box that moves three times under a lamp, and a base where one is
// asked for.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "penumbra/v1/archive.pb.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/blob.h"
#include "render/scene/commit_record.h"
#include "render/scene/scene_difference.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {

inline SceneDelta BoxAndLamp(float height) {
  static const auto mesh = MeshOf(UnitBoxGeometry());
  SceneDelta delta;
  delta.upsert_instances = {
      {.id = "box", .mesh = mesh, .world_from_mesh = Placed({0, height, 0}, 0.4f)}};
  delta.upsert_lights = {{.id = "lamp", .shape = PointLight{.position = {0, 3, 0}}}};
  return delta;
}

// The record of a commit that builds on `chain`, which becomes the one after it.
inline v1::ArchiveRecord RecordOf(const CommitRecord& commit, ContentHash& chain) {
  chain = NextChain(chain, commit, HashOfBytes(commit.delta));
  v1::ArchiveRecord record;
  v1::ArchiveCommit& proto = *record.mutable_commit();
  proto.set_revision(commit.revision);
  proto.set_content_hash(ToProto(commit.content_hash));
  proto.set_idempotency_key(commit.key);
  proto.set_fingerprint(ToProto(commit.fingerprint));
  proto.set_author_name(commit.author);
  proto.set_time_ms(commit.time_ms);
  proto.set_chain(ToProto(chain));
  proto.set_delta_size_bytes(commit.delta.size());
  record.set_data(commit.delta);
  return record;
}

// In two records.
inline void AddMesh(const Mesh& mesh, std::vector<v1::ArchiveRecord>& records) {
  const auto blob = EncodeBlob(mesh.geometry());
  const std::string bytes(reinterpret_cast<const char*>(blob.data()), blob.size());
  v1::ArchiveRecord& first = records.emplace_back();
  first.mutable_blob()->set_hash(ToProto(mesh.id()));
  first.mutable_blob()->set_size_bytes(bytes.size());
  first.set_data(bytes.substr(0, 100));
  records.emplace_back().set_data(bytes.substr(100));
}

// Commits of revisions `base` + 1 to `base` + 3. With a base above 0 there is a snapshot of it.
inline std::vector<v1::ArchiveRecord> SmallArchive(Revision base = 0) {
  std::vector<v1::ArchiveRecord> records(1);
  const auto empty = Scene::Empty("studio");
  auto scene = empty;
  if (base > 0) scene = scene->Apply(BoxAndLamp(1)).value()->WithRevision(base);
  ContentHash chain = HashOfBytes("the chain before");
  v1::ArchiveHead head;
  head.set_format_version(1);
  head.set_scene_id("studio");
  head.set_incarnation(std::string(16, 'i'));
  head.set_base_revision(base);
  head.set_base_content_hash(ToProto(scene->content_hash()));
  head.set_base_chain(ToProto(chain));
  head.set_blob_count(1);
  AddMesh(*BoxAndLamp(1).upsert_instances[0].mesh, records);
  if (base > 0) {
    *records.emplace_back().mutable_base()->mutable_delta() = ToProto(Difference(*empty, *scene));
  }
  for (int i = 1; i <= 3; ++i) {
    const SceneDelta delta = BoxAndLamp(static_cast<float>(1 + i));
    scene = scene->Apply(delta).value();
    records.push_back(RecordOf({.revision = scene->revision(),
                                .content_hash = scene->content_hash(),
                                .key = i == 2 ? "key-2" : "",
                                .fingerprint = {},
                                .author = "tester",
                                .time_ms = 1'700'000'000'000 + i,
                                .delta = ToProto(delta).SerializeAsString()},
                               chain));
  }
  records.emplace_back().mutable_end();
  head.set_revision(scene->revision());
  head.set_content_hash(ToProto(scene->content_hash()));
  head.set_chain(ToProto(chain));
  *records[0].mutable_head() = head;
  return records;
}

// Makes the hashes right after commits have been changed, as if whoever made the archive up had
// kept the books. The bytes of each delta are in its record.
inline void TieAnew(std::vector<v1::ArchiveRecord>& records) {
  v1::ArchiveHead& head = *records[0].mutable_head();
  ContentHash chain = HashFromProto(head.base_chain(), "chain").value();
  for (v1::ArchiveRecord& record : records) {
    if (!record.has_commit()) continue;
    const v1::ArchiveCommit& commit = record.commit();
    record = RecordOf({.revision = commit.revision(),
                       .content_hash = HashFromProto(commit.content_hash(), "hash").value(),
                       .key = commit.idempotency_key(),
                       .fingerprint = HashFromProto(commit.fingerprint(), "hash").value(),
                       .author = commit.author_name(),
                       .time_ms = commit.time_ms(),
                       .delta = record.data()},
                      chain);
  }
  head.set_chain(ToProto(chain));
}

// The same as a call brings them: without the bytes of blobs.
inline std::vector<v1::ArchiveRecord> SmallImport(Revision base = 0) {
  std::vector<v1::ArchiveRecord> records = SmallArchive(base);
  records.erase(records.begin() + 2);
  records[1].clear_data();
  return records;
}

}  // namespace penumbra::testing
