// Commits for tests of what is kept on disk.
#pragma once

#include <string>
#include <vector>

#include "server/storage/scene_file.h"

namespace penumbra::testing {

inline SceneIdentity StudioIdentity() {
  return {.scene_id = "studio", .incarnation = std::string(16, 'i'), .owner = std::string(16, 'o')};
}

// Different for each revision.
inline CommitRecord CommitAt(Revision revision) {
  const std::string text = "delta " + std::to_string(revision);
  return {.revision = revision,
          .content_hash = HashOfBytes("scene " + std::to_string(revision)),
          .key = revision % 3 == 0 ? "key" + std::to_string(revision) : "",
          .fingerprint = HashOfBytes(text),
          .author = "tester",
          .time_ms = static_cast<int64_t>(1'700'000'000'000 + revision),
          .delta = text + std::string(revision % 50, '.')};
}

inline std::vector<CommitRecord> CommitsBetween(Revision first, Revision last) {
  std::vector<CommitRecord> commits;
  for (Revision revision = first; revision <= last; ++revision) {
    commits.push_back(CommitAt(revision));
  }
  return commits;
}

inline SnapshotRecord SnapshotAt(Revision revision) {
  return {.revision = revision,
          .content_hash = CommitAt(revision).content_hash,
          .body = "snapshot " + std::to_string(revision)};
}

// One text for all that a state says.
inline std::string TextOf(const SceneState& state) {
  std::string text;
  if (state.snapshot) {
    text += std::to_string(state.snapshot->revision) + state.snapshot->content_hash.hex() +
            state.snapshot->body + "\n";
  }
  for (const CommitRecord& commit : state.commits) {
    text += std::to_string(commit.revision) + commit.content_hash.hex() + commit.key +
            commit.fingerprint.hex() + commit.author + std::to_string(commit.time_ms) +
            commit.delta + "\n";
  }
  return text;
}

}  // namespace penumbra::testing
