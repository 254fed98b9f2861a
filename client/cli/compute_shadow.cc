#include "client/cli/compute_shadow.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/engine/compute_once.h"

namespace penumbra {

absl::StatusOr<std::shared_ptr<const Artifact>> ComputeShadow(
    Engine& engine, const std::string& scene_id, const ArtifactSpec& spec, const std::string& label,
    ProgressLine& progress, std::stop_token stop) {
  progress.Show(label, 0.0);
  const auto show = [&](const Artifact& artifact) {
    if (const auto* view = std::get_if<ViewShadow>(&artifact.payload)) {
      const ShadingProgress& done = view->progress;
      progress.Show(absl::StrFormat("%s: %.0f %%, %.1f million rays, %.1f s left", label,
                                    100 * done.fraction_done, 1e-6 * done.rays_traced,
                                    1e-3 * done.time_left_ms),
                    done.fraction_done);
      return;
    }
    const ArtifactHeader& header = artifact.header;
    const double needed = header.samples_requested;
    const double counted = static_cast<double>(header.light_samples.size());
    progress.Show(absl::StrCat(label, ": ", counted, " of ", needed, " light samples"),
                  needed > 0.0 ? counted / needed : 0.0);
  };
  return ComputeOnce(engine, scene_id, spec, {.progress = show, .stop = stop});
}

void NoteWarning(const Artifact& artifact, const std::string& label, const Console& console) {
  const auto warning = artifact.header.parameters.find("warning");
  if (warning == artifact.header.parameters.end()) return;
  console.Note(absl::StrCat(label, ": ", warning->second));
}

}  // namespace penumbra
