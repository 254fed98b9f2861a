#include "server/processor_admission.h"

#include "server/scene_store/commit_admission.h"

namespace penumbra {

absl::Status ProcessorAdmission::AdmitCommit(const std::string& principal, const void* session) {
  const double lot = read_delay_.OnRequest();
  const double share = shares_.OnRequest(principal, session);
  return AdmitByReadDelay(read_delay_.Now(), lot, share, limits_);
}

}  // namespace penumbra
