// Image files: PNG for screens, EXR for numbers.
//
//   absl::Status status = WritePng("view.png", width, height, ToSrgb(picture, tone));
//   const NamedPlane planes[] = {{"count", counts}, {"R", red}, {"G", green}, {"B", blue}};
//   status = WriteExr("floor.exr", width, height, planes);
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/display/picture.h"

namespace penumbra {

// One channel of an image: H×W values, row 0 written first.
struct NamedPlane {
  std::string name;
  std::span<const float> values;
  bool half = false;  // in an EXR: 16-bit floats, to the nearest, instead of 32-bit ones
};

// All that write: kUnavailable, with the path and why: cannot be written, and nothing is left
// behind; kInvalidArgument: sizes that do not agree.

// H×W×3 bytes in sRGB.
absl::Status WritePng(const std::filesystem::path& path, int width, int height,
                      std::span<const uint8_t> rgb);

// Floats, channels as named.
absl::Status WriteExr(const std::filesystem::path& path, int width, int height,
                      std::span<const NamedPlane> planes);
// Channels R, G, B and A.
absl::Status WriteExr(const std::filesystem::path& path, const Picture& picture);

struct Planes {
  int width = 0;
  int height = 0;
  std::map<std::string, std::vector<float>> values;  // channel → H·W, row 0 of the file first
};

// Any file that OpenImageIO reads; bytes become [0, 1].
// Errors  kNotFound, kInvalidArgument with the path and why
absl::StatusOr<Planes> ReadImage(const std::filesystem::path& path);

}  // namespace penumbra
