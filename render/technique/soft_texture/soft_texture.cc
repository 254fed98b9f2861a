#include "render/technique/soft_texture/soft_texture.h"

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {

absl::Status SoftTexture::Check(const Scene&, const ArtifactSpec&) const { return absl::OkStatus(); }

absl::StatusOr<Artifact> SoftTexture::Compute(const Scene&, const ArtifactSpec&,
                                              const ComputeContext&) const {
  return absl::UnimplementedError("soft_texture is being written");
}

}  // namespace penumbra
