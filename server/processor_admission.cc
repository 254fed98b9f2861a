#include "server/processor_admission.h"

#include "server/scene_store/commit_admission.h"

namespace penumbra {

absl::Status ProcessorAdmission::AdmitCommit(const std::string& principal, const void* session,
                                             bool has_unanswered) {
  const double lot = read_delay_.OnRequest();
  const CommitSender sender{.share = shares_.OnRequest(principal, session),
                            .has_unanswered = has_unanswered};
  const absl::Status status = AdmitByReadDelay(read_delay_.Now(), lot, sender, limits_);
  read_delay_.OnAdmission(!status.ok());
  return status;
}

}  // namespace penumbra
