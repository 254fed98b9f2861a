// Archives that somebody hands to a client: made up with right hashes, or damaged. What is taken is
// a scene at each of its revisions, can be written again byte by byte and be imported; a damaged
// file never is.

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "client/session/scene_archive.h"
#include "penumbra/v1/archive.pb.h"
#include "proto/archive/archive_file.h"
#include "proto/archive/archive_file_reader.h"
#include "proto/archive/archive_file_writer.h"
#include "proto/archive/archive_order.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/blob.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/kit/target.h"
#include "tests/fuzz/targets/archive_books.h"
#include "tests/fuzz/targets/payload_numbers.h"
#include "tests/fuzz/targets/scene_rules.h"
#include "tests/fuzz/targets/scratch_file.h"
#include "tests/fuzz/targets/small_studio.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::fuzzing {
namespace {

// Damage is a place and what to change there; 0 cuts the file off.
enum Kind : uint8_t { kHead, kBlob, kBase, kCommit, kRecord, kDamage, kKinds };

using Records = std::vector<v1::ArchiveRecord>;

std::string FileOf(const Records& records) {
  std::string bytes(kArchiveFirstLine);
  ContentHash seal = FirstSeal();
  for (const v1::ArchiveRecord& record : records) {
    std::string framed = SizeText(static_cast<uint32_t>(record.ByteSizeLong()));
    record.AppendToString(&framed);
    seal = NextSeal(seal, framed);
    bytes.append(framed).append(BytesOf(seal));
  }
  return bytes;
}

void Damage(const std::string& payload, std::string& bytes) {
  PayloadNumbers numbers(payload);
  if (bytes.empty()) return;
  const size_t at = numbers.Next(4) % bytes.size();
  const auto change = static_cast<char>(numbers.Next(1));
  if (change == 0) return bytes.resize(at);
  bytes[at] = static_cast<char>(bytes[at] ^ change);
}

// As a call brings them: blobs have been uploaded before.
Records WithoutBlobBytes(const Records& records) {
  Records left;
  bool is_in_blob = false;
  for (const v1::ArchiveRecord& record : records) {
    const bool goes_on = record.begins_case() == v1::ArchiveRecord::BEGINS_NOT_SET;
    if (goes_on && is_in_blob) continue;
    is_in_blob = record.has_blob();
    left.push_back(record);
    if (is_in_blob) left.back().clear_data();
  }
  return left;
}

template <typename Message>
std::optional<Message> Parsed(const std::string& payload) {
  Message message;
  if (!message.ParseFromString(payload)) return std::nullopt;
  return message;
}

void AddStep(const Step& step, ArchiveBooks& books) {
  switch (step.kind % kKinds) {
    case kHead:
      if (const auto head = Parsed<v1::ArchiveHead>(step.payload)) books.AddHead(*head);
      return;
    case kBlob:
      return books.AddBlob(step.payload);
    case kBase:
      if (const auto delta = Parsed<v1::SceneDelta>(step.payload)) books.AddBase(*delta);
      return;
    case kCommit:
      if (const auto delta = Parsed<v1::SceneDelta>(step.payload)) books.AddCommit(*delta);
      return;
    case kRecord:
      if (const auto record = Parsed<v1::ArchiveRecord>(step.payload)) books.Add(*record);
      return;
  }
}

class Archives final : public Target {
 public:
  std::span<const StepKind> kinds() const override { return kinds_; }
  void Run(const Script& script) override;
  std::vector<Seed> Seeds() override;

 private:
  // Whether the file is taken; what it tells is checked.
  bool Read(const std::string& bytes) const;
  void CheckWrittenAgain(const std::string& bytes) const;
  void CheckImported(const Records& records) const;

  const StepKind kinds_[kKinds] = {{"head", &v1::ArchiveHead::default_instance()},
                                   {"blob"},
                                   {"base", &v1::SceneDelta::default_instance()},
                                   {"commit", &v1::SceneDelta::default_instance()},
                                   {"record", &v1::ArchiveRecord::default_instance()},
                                   {"damage"}};
  const testing::TemporaryFolder folder_;
  const std::string path_ = folder_ / "studio.penumbra";
};

void Archives::Run(const Script& script) {
  ArchiveBooks books;
  for (const Step& step : script) AddStep(step, books);
  const std::string whole = FileOf(books.Close());
  const bool is_taken = Read(whole);
  Count(is_taken);
  if (is_taken) CheckWrittenAgain(whole);
  std::string damaged = whole;
  for (const Step& step : script) {
    if (step.kind % kKinds == kDamage) Damage(step.payload, damaged);
  }
  if (damaged == whole) return;
  const bool is_damaged_taken = Read(damaged);
  Count(is_damaged_taken);
  Require(!is_taken || !is_damaged_taken, "a damaged file is refused");
}

bool Archives::Read(const std::string& bytes) const {
  WriteAnew(path_, bytes);
  std::optional<Revision> revision;
  const auto info =
      ReadArchive(path_, {.on_base =
                              [&](const auto& scene) {
                                revision = scene->revision();
                                RequireRules(*scene, {});
                                return absl::OkStatus();
                              },
                          .on_change =
                              [&](const ArchivedChange& change) {
                                Require(revision && change.scene->revision() == *revision + 1,
                                        "commits come after the base, in order");
                                revision = change.scene->revision();
                                RequireRules(*change.scene, {});
                                return absl::OkStatus();
                              }});
  if (!info.ok()) {
    RequireNamedRefusal(info.status());
    return false;
  }
  Require(revision == info->revision && info->scene->revision() == info->revision,
          "the last commit makes the newest scene");
  Require(info->file_bytes == bytes.size(), "all of the file is read");
  return true;
}

void Archives::CheckWrittenAgain(const std::string& bytes) const {
  const std::string again = folder_ / "again.penumbra";
  Records records;
  {
    const auto reader = ArchiveFileReader::Open(path_);
    const auto writer = ArchiveFileWriter::Create(again);
    Require(reader.ok() && writer.ok(), "files can be opened");
    while (true) {
      auto record = (*reader)->Next();
      Require(record.ok(), "what was read can be read again");
      if (!*record) break;
      Require((*writer)->Write(**record).ok(), "records can be written");
      records.push_back(**std::move(record));
    }
    Require((*writer)->Finish().ok(), "an archive can be written");
  }
  Require(BytesIn(again) == bytes, "an archive is written as it was read");
  CheckImported(records);
}

void Archives::CheckImported(const Records& records) const {
  ArchiveOrder order({.has_blob_bytes = false});
  for (const v1::ArchiveRecord& record : WithoutBlobBytes(records)) {
    const auto step = order.Take(record);
    Require(step.ok(), "what a client reads a server takes: " + step.status().ToString());
  }
  Require(order.has_ended(), "nothing is missing");
}

std::string BlobOf(const Mesh& mesh) {
  const auto bytes = EncodeBlob(mesh.geometry());
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string MaskBytes() {
  const auto bytes = EncodeBlob(*StudioMask());
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string Text(const SceneDelta& delta) { return ToProto(delta).SerializeAsString(); }

std::string HeadAt(Revision base) {
  v1::ArchiveHead head;
  head.set_base_revision(base);
  head.set_server_name("penumbra 0.1.0");
  return head.SerializeAsString();
}

v1::SceneDelta NoBox() {
  v1::SceneDelta delta;
  delta.add_remove_receivers("side");
  delta.add_remove_instances("box");
  return delta;
}

std::vector<Seed> Archives::Seeds() {
  const Script blobs = {
      {kBlob, BlobOf(*StudioBox())}, {kBlob, BlobOf(*StudioSquare())}, {kBlob, MaskBytes()}};
  const auto after_blobs = [&](Script more) {
    more.insert(more.begin(), blobs.begin(), blobs.end());
    return more;
  };
  SceneDelta lights;
  lights.upsert_lights = {{.id = "late", .shape = PointLight{.position = {0, 3, 0}}}};
  v1::ArchiveRecord bytes;
  bytes.set_data("more");
  return {
      {"history", after_blobs({{kCommit, Text(StudioDelta())},
                               {kCommit, Text(BoxAt(1))},
                               {kCommit, NoBox().SerializeAsString()}})},
      {"base", after_blobs({{kHead, HeadAt(7)},
                            {kBase, Text(StudioDelta())},
                            {kBase, Text(lights)},
                            {kCommit, Text(BoxAt(1))}})},
      {"flipped", {{kCommit, Text(lights)}, {kDamage, std::string("\x40\x00\x00\x00\x04", 5)}}},
      {"cut", {{kCommit, Text(lights)}, {kDamage, std::string("\xf0\x00\x00\x00\x00", 5)}}},
      {"bytes of nothing", {{kCommit, Text(lights)}, {kRecord, bytes.SerializeAsString()}}},
  };
}

}  // namespace

Target& TheTarget() {
  static Archives target;
  return target;
}

}  // namespace penumbra::fuzzing
