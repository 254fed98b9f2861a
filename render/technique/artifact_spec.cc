#include "render/technique/artifact_spec.h"

#include "absl/strings/str_cat.h"

namespace penumbra {
namespace {

std::string KeyOf(const SoftTextureParams& params) {
  return absl::StrCat(params.samples, " ", params.seed, " ", params.radiance, " ",
                      static_cast<int>(params.method));
}

}  // namespace

// Ids hold no blanks, so that the parts cannot run into each other.
std::string SpecKey(const ArtifactSpec& spec) {
  const std::string_view name = InfoOf(spec.params).name;
  return absl::StrCat(absl::string_view(name.data(), name.size()), " ", spec.light_id, " ",
                      spec.receiver_id, " ",
                      std::visit([](const auto& params) { return KeyOf(params); }, spec.params));
}

}  // namespace penumbra
