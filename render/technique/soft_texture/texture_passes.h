// One light's texture, computed pass by pass: each counts more of the same samples.
//
//   TexturePasses passes(scene, spec, context);
//   auto artifact = passes.Next();  // coarse, or final already
//   artifact = passes.Last();       // final
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/scene.h"
#include "render/technique/soft_texture/borrowed_outlines.h"
#include "render/technique/soft_texture/gl/gl_shadows.h"
#include "render/technique/soft_texture/kept_shadows.h"
#include "render/technique/soft_texture/occlusion_counter.h"
#include "render/technique/soft_texture/receiver_coverage.h"
#include "render/technique/soft_texture/texture_shading.h"
#include "render/technique/stopwatch.h"
#include "render/technique/technique.h"

namespace penumbra {

class TexturePasses {
 public:
  // `spec` must pass CheckSpec and name one light; the method gl needs `context.gl`. Passes are
  // coarse at first only where `context.progress` is there, which is never called. Refers to all
  // three.
  TexturePasses(const Scene& scene, const ArtifactSpec& spec, const ComputeContext& context);
  TexturePasses(const TexturePasses&) = delete;
  TexturePasses& operator=(const TexturePasses&) = delete;

  // The next pass, or all the samples that are left at once; not after the final one.
  //
  // Errors  kCancelled: stop requested
  absl::StatusOr<Artifact> Next();
  absl::StatusOr<Artifact> Last();

 private:
  TexturePasses(const Scene& scene, const ArtifactSpec& spec, const ComputeContext& context,
                const ReceiverPatch& receiver);

  const SoftTextureParams& params() const { return std::get<SoftTextureParams>(spec_.params); }
  uint32_t sample_count() const { return static_cast<uint32_t>(samples_.size()); }

  EditPlan Plan() const;
  std::vector<LightSample> Samples() const;
  SoftTextureParams ShadingParams() const;
  ShadowRules Rules() const;
  CasterChoice CastersOf(bool moving) const;
  void FillHeader();

  FirstPassPace* Pace() const;
  uint32_t FirstPassSamples() const;
  bool IsBaseDrawn() const;

  absl::StatusOr<Artifact> Advance(uint32_t upto);
  absl::Status Draw(uint32_t upto);
  absl::Status ExtendBase(uint32_t upto);
  void StartCounts();
  std::vector<uint16_t> VisibleCounts();
  absl::StatusOr<double> ErrorOfBorrowing();
  absl::StatusOr<double> ErrorOfBorrowing(const CasterChoice& casters);
  void Shade(SoftShadowTexture& texture);
  Artifact MakeArtifact();

  const ArtifactSpec& spec_;
  const ComputeContext& context_;
  Stopwatch watch_;  // since the beginning of the pass
  ReceiverCoverage coverage_;
  ReceiverPatch receiver_;
  std::shared_ptr<const AreaLight> light_;
  double surface_offset_;
  const Scene& scene_;
  EditPlan plan_;
  std::vector<LightSample> samples_, lenders_;  // lenders: where outlines are borrowed
  // What is drawn over the base, or everything where there is none; and what of the base has to be
  // drawn.
  OcclusionCounter moving_;
  std::optional<OcclusionCounter> still_;
  bool counts_have_base_ = false;   // those of moving_
  std::optional<GlShadows> on_gl_;  // in place of both
  TextureShading shading_;
  uint32_t done_ = 0;  // samples
  double compute_ms_ = 0;
  ArtifactHeader header_;
};

}  // namespace penumbra
