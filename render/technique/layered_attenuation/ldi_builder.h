// Gathers depth maps from many points of a light into one layered depth image.
//
//   LdiBuilder builder(center, 0.5f, limits);
//   for (…) if (auto status = builder.Insert(std::move(maps), arena, stop); !status.ok()) …
//   LdiFace face = builder.Finish();  // at any time, of the maps so far
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "render/artifact/attenuation_ldi.h"
#include "render/artifact/depth_map.h"
#include "render/technique/layered_attenuation/layer_band.h"
#include "render/technique/layered_attenuation/ldi_use.h"
#include "render/technique/layered_attenuation/seen_surface.h"
#include "tbb/task_arena.h"

namespace penumbra {

struct LdiLimits {
  uint32_t max_layers = 64;  // a pixel
  // Of layers and of maps, of all faces; not of what draws maps.
  size_t max_bytes = size_t{1} << 30;
  // Of these, of the maps of each face: sixteen of 512² pixels. Without any the 99th percentile of
  // the error on the scenes of the accuracy test was up to 0.006 higher, with 64 maps 0.002 lower,
  // at 64 samples as at 256.
  size_t max_kept_bytes = size_t{16} << 20;
};

// Each layer is looked up in each map, which counts it once; a map's pixels that no layer explains
// become layers where they fall in the middle view, and are looked up in the maps that came before,
// as far as these are kept.
//
// Source  Agrawala et al. 2000, §4, procedure Precompute; departs: layers are looked up in maps
//         instead of maps' pixels in layers, so that none is counted beside its edge and none has
//         holes
class LdiBuilder {
 public:
  // Of a map: nearness, and whether it is explained.
  static constexpr size_t kBytesPerPixel = sizeof(float) + 1;

  // tolerance  how far apart depths of one layer may be, in pixels' widths; where that is less than
  //            rounding to single precision does, as much as that
  // use        not null
  LdiBuilder(const LightView& center, float tolerance, const LdiLimits& limits,
             std::shared_ptr<LdiUse> use = std::make_shared<LdiUse>());
  LdiBuilder(const LdiBuilder&) = delete;
  LdiBuilder& operator=(const LdiBuilder&) = delete;

  // Makes layers of what a map sees, which no sample has counted yet. That of the middle itself has
  // whatever hides a surface from there known, even where it is too near to the light for samples'
  // windows.
  //
  // Errors  as Insert
  absl::Status AddSurfaces(DepthMap map, tbb::task_arena& arena, const std::stop_token& stop);
  // Takes maps of views with the frame and the pitch of the middle's. The same maps in the same
  // portions give the same layers, for any number of threads.
  //
  // Errors  kCancelled; kResourceExhausted: QUOTA_LDI_LAYERS, "max_layers", or QUOTA_LDI_BYTES,
  //         "resolution", after which Insert is of no more use
  // Cost    about 4 ns a layer and map, and what is new
  absl::Status Insert(std::vector<DepthMap> maps, tbb::task_arena& arena,
                      const std::stop_token& stop);
  // The same, but counts the layers that there are and makes none.
  absl::Status InsertKnown(std::vector<DepthMap> maps, tbb::task_arena& arena,
                           const std::stop_token& stop);
  // Of a sample from whose view all that there is is cut.
  void InsertNothing() { ++sample_count_, ++unhidden_; }

  uint32_t sample_count() const { return sample_count_; }
  size_t layer_count() const;
  const LightView& center() const { return center_; }
  float pixel_width() const { return pixel_width_; }     // on the image plane
  float tolerance() const { return tolerance_.pixels; }  // in effect
  const std::vector<LayerBand>& bands() const { return bands_; }
  // Counts are out of sample_count().
  LdiFace Finish() const;

 private:
  // What no layer explains of some of a map's rows, in the middle view, and in which rows there.
  struct Unexplained {
    std::vector<PixelSurface> surfaces;
    uint32_t first_row, end_row;
  };
  struct Map {
    NearnessMap seen;
    ViewWarp warp;
    std::vector<uint8_t> explained;  // one a pixel, and one more
    std::vector<Unexplained> unexplained;
    LdiLease lease;  // of all this
  };

  std::vector<Map> MapsOf(std::vector<DepthMap> depth_maps) const;
  Unexplained FindUnexplained(const Map& map, uint32_t block) const;
  void Add(std::span<const Unexplained> unexplained, LayerBand& band);
  void Discover(std::span<Map> maps, const std::stop_token& stop);
  void Count(std::span<const size_t> known, std::span<Map> maps, const std::stop_token& stop);
  void Keep(std::span<Map> maps);
  // Calls `work` with the maps, unless they are too large already.
  template <typename Work>
  absl::Status WorkOn(std::vector<DepthMap> depth_maps, tbb::task_arena& arena,
                      const std::stop_token& stop, const Work& work);
  absl::Status Outcome(const std::stop_token& stop) const;

  const LightView center_;
  const float pixel_width_;
  const LayerTolerance tolerance_;
  const LdiLimits limits_;
  uint32_t sample_count_ = 0;
  uint32_t unhidden_ = 0;  // samples that hide nothing
  std::vector<LayerBand> bands_;
  std::vector<Map> kept_;
  size_t kept_bytes_ = 0;
  const std::shared_ptr<LdiUse> use_;
  std::atomic<bool> too_many_{false};  // layers at a pixel
};

}  // namespace penumbra
