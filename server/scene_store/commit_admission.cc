#include "server/scene_store/commit_admission.h"

#include <algorithm>
#include <chrono>
#include <string>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"

namespace penumbra {
namespace {

using Ms = std::chrono::duration<double, std::milli>;

// What is behind by so much has caught up about as long after, if nothing more comes. Not shorter
// than a few transactions take, and not so long that a disk that works again stands idle.
constexpr double kLeastRetryMs = 50;
constexpr double kMostRetryMs = 5'000;

absl::Status TooMuch(const char* reason, const std::string& text, double behind_ms) {
  return WithRetryDelay(FieldError(absl::StatusCode::kResourceExhausted, reason, "commit", text),
                        std::clamp(behind_ms, kLeastRetryMs, kMostRetryMs));
}

absl::Status TooManyBytes(uint64_t found, uint64_t most, const char* of_whom, double behind_ms) {
  return TooMuch("QUOTA_PENDING_BYTES",
                 absl::StrCat("found ", found,
                              " bytes of commits on their way to the disk with this one, need at "
                              "most ",
                              most, " ", of_whom),
                 behind_ms);
}

absl::Status AdmitToScene(uint64_t bytes, const SceneBacklog& scene, const ServerLimits& limits,
                          double waited_ms) {
  if (scene.commits >= limits.max_pending_commits) {
    return TooMuch(
        "QUOTA_PENDING",
        absl::StrCat("found ", scene.commits, " commits on their way to the disk, need fewer than ",
                     limits.max_pending_commits, " of one scene"),
        waited_ms);
  }
  if (scene.bytes + bytes <= limits.max_pending_commit_bytes) return absl::OkStatus();
  return TooManyBytes(scene.bytes + bytes, limits.max_pending_commit_bytes, "of one scene",
                      waited_ms);
}

// In which parts of the limit some commits are refused, the more the nearer it is to the upper end.
struct Range {
  double begin = 0, end = 1;
};
constexpr Range kOfMany{.begin = 0.1, .end = 1};
// Of those who send one at a time no more wait than there are of them. Where that is not many, they
// would lose more by coming back later than by waiting.
constexpr Range kOfFew{.begin = 4, .end = 8};
constexpr size_t kFewSessions = 64;
// Whoever sends less than this part of what others do is refused less often. Not 1: those who are
// told to wait send by fits and starts.
constexpr double kMuchLess = 0.5;
// Not all: whoever comes again and again is let in, whoever else sends how much.
constexpr double kMostRefusedPart = 0.95;
// Long enough that few who are refused hold back most of what comes, and spread: those who are
// refused together are not to come back together.
constexpr double kLeastReadRetryMs = 200, kMostReadRetryMs = 600;

}  // namespace

absl::Status AdmitByReadDelay(StorageBacklog::Clock::duration waited, double lot,
                              const CommitSender& sender, const ServerLimits& limits) {
  const double waited_ms = Ms(waited).count(), most_ms = limits.max_read_delay_ms;
  if (most_ms == 0) return absl::OkStatus();
  const bool is_one_of_few = !sender.has_unanswered && sender.share.sessions <= kFewSessions;
  const Range& range = is_one_of_few ? kOfFew : kOfMany;
  const double part = (waited_ms / most_ms - range.begin) / (range.end - range.begin);
  const double refused_part =
      std::min(part, kMostRefusedPart) * std::min(sender.share.of_mean / kMuchLess, 1.0);
  if (lot >= refused_part) return absl::OkStatus();
  // Of those that are refused the lots are spread over [0, refused_part).
  const double spread = lot / refused_part;
  return TooMuch("OVERLOADED",
                 absl::StrCat("found requests read ", static_cast<int64_t>(waited_ms),
                              " ms after they came, need at most ", limits.max_read_delay_ms),
                 kLeastReadRetryMs + spread * (kMostReadRetryMs - kLeastReadRetryMs));
}

absl::Status AdmitCommit(const CommitRequest& request, const SceneBacklog& scene,
                         const StorageBacklog& all, const ServerLimits& limits,
                         StorageBacklog::Clock::time_point now) {
  double behind_ms = Ms(all.Age(now)).count();
  if (scene.commits > 0) {
    const double waited_ms = Ms(now - scene.oldest_came).count();
    if (auto status = AdmitToScene(request.bytes, scene, limits, waited_ms); !status.ok()) {
      return status;
    }
    behind_ms = std::max(behind_ms, waited_ms);
  }
  const uint64_t theirs = all.BytesOf(request.principal) + request.bytes;
  const uint64_t share = all.ShareOf(request.principal, limits.max_all_pending_commit_bytes);
  if (theirs > share) {
    return TooManyBytes(theirs, share, "of all scenes of one principal, half of what others leave",
                        behind_ms);
  }
  if (behind_ms <= limits.max_commit_delay_ms) return absl::OkStatus();
  return TooMuch("OVERLOADED",
                 absl::StrCat("found the disk ", static_cast<int64_t>(behind_ms),
                              " ms behind, need at most ", limits.max_commit_delay_ms),
                 behind_ms);
}

}  // namespace penumbra
