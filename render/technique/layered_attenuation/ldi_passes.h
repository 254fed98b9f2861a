// The attenuation LDI of a scene and a light, computed pass by pass: each counts more of the same
// samples.
//
//   auto passes = LdiPasses::Create(scene, light, options, source, arena);
//   if (auto status = (*passes)->Advance(8, stop); !status.ok()) return status;
//   AttenuationLdi coarse = (*passes)->Finish();
//   … (*passes)->Advance((*passes)->sample_count(), stop) …
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/artifact/attenuation_ldi.h"
#include "render/light_view/depth_source.h"
#include "render/light_view/light_face.h"
#include "render/scene/light_sample.h"
#include "render/scene/scene.h"
#include "render/technique/layered_attenuation/layered_attenuation_params.h"
#include "render/technique/layered_attenuation/ldi_builder.h"
#include "tbb/task_arena.h"

namespace penumbra {

// What rounding to pixels can do (AttenuationLdi::tolerance).
inline constexpr float kAutomaticLdiTolerance = 1.0f;

struct LdiOptions {
  uint32_t samples = 64;      // light samples, 1 to 1,024
  uint64_t seed = 1;          // of the jitter
  uint32_t resolution = 512;  // pixels along the longer side of a face
  // AttenuationLdi::tolerance, of which the layers themselves get half; in (0, kMaxLdiTolerance],
  // and more in effect where rounding takes more. None: kAutomaticLdiTolerance.
  std::optional<float> tolerance{};
  bool key_views = false;  // the middle's and the rim's depth maps stand for all samples'
  LdiLimits limits{};
};

// Errors  kInvalidArgument RANGE, which names the field as "samples", "resolution", "tolerance"
absl::Status CheckLdiOptions(const LdiOptions& options);

// Something that light falls on and that casts no shadow (SurfacesWithoutShadows).
struct SeenSurface {
  std::shared_ptr<const Scene> scene;
  DepthSource* source;  // which draws it; referred to
};

class LdiPasses {
 public:
  // Samples whose depth maps layers are looked up in at a time: more have the layers read less
  // often, and take more memory. With 16 it was as quick.
  static constexpr uint32_t kPortion = 8;

  // All casting instances of `scene` are in the LDI, and `seen`. `source` must draw `scene`; it and
  // `arena` are referred to.
  //
  // Errors  those of CheckLdiOptions; kResourceExhausted QUOTA_LDI_BYTES, "resolution", where the
  //         least that it can take is too much; VIEW_SIZE, "resolution": more than kMaxViewSide
  //         pixels along a side of a sample's view
  static absl::StatusOr<std::unique_ptr<LdiPasses>> Create(
      const Scene& scene, const AreaLight& light, const LdiOptions& options, DepthSource& source,
      tbb::task_arena& arena, std::vector<SeenSurface> seen = {});

  // Of the light, which may need fewer than were asked for.
  uint32_t sample_count() const { return sample_count_; }
  uint32_t done() const { return done_; }
  // Those done; where faces have samples of their own, as on a sphere, face by face.
  std::vector<LightSample> samples_done() const;
  // AttenuationLdi::tolerance, in effect.
  float tolerance() const;

  // Counts samples, in whole portions, until at least `upto` are done, or all. Whatever the passes
  // in between, the same number of samples gives the same bits. After an error nothing more can be
  // counted.
  //
  // Errors  kCancelled: stop requested (asked at least once per sample); VIEW_SIZE as above; those
  //         of LdiBuilder and of the source
  absl::Status Advance(uint32_t upto, const std::stop_token& stop);

  // Of the samples done, at least 1.
  AttenuationLdi Finish() const;

 private:
  struct Face {
    const LightView& center() const { return keys.front(); }

    LightFace face;
    std::vector<LightSample> samples;
    std::vector<LightView> keys;  // the middle's, then those of KeySamples
    std::unique_ptr<LdiBuilder> builder;
    // What key views see of what casts, where something else is in the LDI too; otherwise null.
    std::unique_ptr<LdiBuilder> casters;
  };

  // Of some samples, but for those that see nothing.
  struct SampleViews {
    std::vector<LightView> views;
    std::vector<size_t> indices;  // which sample each is of
  };

  LdiPasses(const AreaLight& light, const LdiOptions& options, DepthSource& source,
            tbb::task_arena& arena, std::vector<SeenSurface> seen);

  absl::Status AddFace(const LightFace& face);
  void MakeBuilders(Face& face);
  // Of a layer at each pixel and of a portion of maps like the key views'.
  size_t LeastBytes() const;
  absl::StatusOr<SampleViews> ViewsOf(const Face& face, std::span<const LightSample> samples) const;
  absl::Status Draw(const SampleViews& samples, LdiBuilder& builder, const std::stop_token& stop);
  absl::Status Synthesize(std::span<const LightView> views, Face& face,
                          const std::stop_token& stop);
  absl::Status AddSurfaces(DepthSource& source, std::span<const LightView> views,
                           LdiBuilder& builder, const std::stop_token& stop);
  absl::Status Start(Face& face, const std::stop_token& stop);
  absl::Status Advance(Face& face, uint32_t upto, const std::stop_token& stop);

  const AreaLight light_;
  const LdiOptions options_;
  DepthSource& source_;
  const std::vector<SeenSurface> seen_;
  tbb::task_arena& arena_;
  const float tolerance_;
  const uint32_t sample_count_;
  const std::shared_ptr<LdiUse> use_ = std::make_shared<LdiUse>();
  std::vector<Aabb> boxes_;  // of what casts and of what is seen besides
  bool has_casters_ = false;
  std::vector<Face> faces_;
  uint32_t done_ = 0;
};

}  // namespace penumbra
