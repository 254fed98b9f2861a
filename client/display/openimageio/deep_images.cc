#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "client/display/light_text.h"
#include "client/display/openimageio/images.h"

namespace penumbra::openimageio {
namespace {

constexpr char kView[] = "penumbra:view";
constexpr char kLight[] = "penumbra:light";
constexpr char kSampleCount[] = "penumbra:sample_count";
constexpr char kTolerance[] = "penumbra:tolerance";

enum Channel { kDepth, kAttenuation, kChannelCount };

// All numbers of a view, in a fixed order.
std::vector<double> NumbersOf(const LightView& view) {
  std::vector<double> numbers;
  const auto& [s, t, n] = view.frame.axes;
  for (const DVec3& v : {view.frame.origin, s, t, n, view.eye}) {
    numbers.insert(numbers.end(), {v.x, v.y, v.z});
  }
  numbers.insert(numbers.end(),
                 {view.window.min.x, view.window.min.y, view.window.max.x, view.window.max.y,
                  view.near, view.far, view.from_infinity ? 1.0 : 0.0});
  return numbers;
}

std::string TextOf(const LightView& view) {
  std::string text;
  for (const double number : NumbersOf(view)) absl::StrAppendFormat(&text, " %.17g", number);
  return text.substr(1);
}

bool ReadView(const std::string& text, LightView& view) {
  std::vector<double> n;
  for (const auto word : absl::StrSplit(text, ' ')) {
    double number = 0;
    if (!absl::SimpleAtod(word, &number) || !std::isfinite(number)) return false;
    n.push_back(number);
  }
  if (n.size() != NumbersOf(view).size()) return false;
  const auto vec = [&](size_t i) { return DVec3(n[i], n[i + 1], n[i + 2]); };
  view.frame = {.origin = vec(0), .axes = {.s = vec(3), .t = vec(6), .n = vec(9)}};
  view.eye = vec(12);
  view.window = {.min = {n[15], n[16]}, .max = {n[17], n[18]}};
  view.near = n[19];
  view.far = n[20];
  view.from_infinity = n[21] != 0;
  return !view.window.empty();
}

// Row vectors times matrix, as OpenEXR has it: from the world to the frame, x to the right, y down
// the image, z to where the view looks.
DMat4 CameraFromWorld(const LightView& view) {
  const auto& [s, t, n] = view.frame.axes;
  const DVec3 eye = view.from_infinity ? view.frame.origin : view.frame.ToWorld(view.eye);
  DMat4 camera(1.0);
  for (int row = 0; row < 3; ++row) {
    camera[row] = DVec4(s[row], t[row], n[row], 0);
  }
  camera[3] = DVec4(-glm::dot(eye, s), -glm::dot(eye, t), -glm::dot(eye, n), 1);
  return camera;
}

// Then to x and y in [−1, 1] over the window and z / w, which is the depth from near to far.
DMat4 NdcFromCamera(const LightView& view) {
  const DVec2 scale = 2.0 / view.window.size();
  const DVec2 shift = -(view.window.min + view.window.max) / view.window.size();
  const double depth = view.far > view.near ? view.far - view.near : 1.0;
  DMat4 ndc(0.0);
  ndc[0][0] = scale.x;
  ndc[1][1] = scale.y;
  if (view.from_infinity) {
    ndc[2][2] = 1 / depth;
    ndc[3] = DVec4(shift, -view.near / depth, 1);
  } else {
    ndc[2] = DVec4(shift, view.far / depth, 1);
    ndc[3][2] = -view.far * view.near / depth;
  }
  return ndc;
}

void SetMatrix(OIIO::ImageSpec& spec, const char* name, const DMat4& matrix) {
  float numbers[16];
  for (int i = 0; i < 16; ++i) numbers[i] = static_cast<float>(matrix[i / 4][i % 4]);
  spec.attribute(name, OIIO::TypeMatrix, numbers);
}

OIIO::ImageSpec SpecOf(const AttenuationLdi& ldi, size_t index) {
  const LightView& view = ldi.faces[index].view;
  OIIO::ImageSpec spec(static_cast<int>(view.width), static_cast<int>(view.height), kChannelCount,
                       OIIO::TypeDesc::FLOAT);
  spec.channelnames = {"Z", "attenuation"};
  spec.deep = true;
  // OpenEXR wants one display window for all parts.
  for (const LdiFace& face : ldi.faces) {
    spec.full_width = std::max(spec.full_width, static_cast<int>(face.view.width));
    spec.full_height = std::max(spec.full_height, static_cast<int>(face.view.height));
  }
  spec.attribute("compression", "zips");
  spec.attribute("oiio:subimagename", absl::StrCat("face", index));
  const DMat4 camera = CameraFromWorld(view);
  SetMatrix(spec, "worldToCamera", camera);
  SetMatrix(spec, "worldToNDC", NdcFromCamera(view) * camera);
  spec.attribute(kView, TextOf(view));
  spec.attribute(kLight, LightText(ldi.light));
  spec.attribute(kSampleCount, static_cast<int>(ldi.sample_count));
  spec.attribute(kTolerance, ldi.tolerance);
  return spec;
}

OIIO::DeepData PixelsOf(const LdiFace& face, uint32_t sample_count, const OIIO::ImageSpec& spec) {
  const size_t pixels = face.offsets.size() - 1;
  std::vector<unsigned> layers(pixels);
  for (size_t p = 0; p < pixels; ++p) layers[p] = face.offsets[p + 1] - face.offsets[p];
  OIIO::DeepData deep(spec);
  deep.set_all_samples(layers);
  for (size_t p = 0; p < pixels; ++p) {
    for (unsigned k = 0; k < layers[p]; ++k) {
      const size_t i = face.offsets[p] + k;
      const float seen = static_cast<float>(face.counts[i]) / static_cast<float>(sample_count);
      const auto pixel = static_cast<int64_t>(p);
      deep.set_deep_value(pixel, kDepth, static_cast<int>(k), face.depths[i]);
      deep.set_deep_value(pixel, kAttenuation, static_cast<int>(k), seen);
    }
  }
  return deep;
}

// Nothing is thrown past this; an empty text: it is written.
std::string Write(const std::filesystem::path& path, const AttenuationLdi& ldi) {
  try {
    std::vector<OIIO::ImageSpec> specs;
    for (size_t i = 0; i < ldi.faces.size(); ++i) specs.push_back(SpecOf(ldi, i));
    const std::unique_ptr<OIIO::ImageOutput> file = OIIO::ImageOutput::create("openexr");
    if (file == nullptr) return OIIO::geterror();
    bool is_written = file->open(path.string(), static_cast<int>(specs.size()), specs.data());
    for (size_t i = 0; is_written && i < specs.size(); ++i) {
      if (i > 0) {
        is_written = file->open(path.string(), specs[i], OIIO::ImageOutput::AppendSubimage);
      }
      is_written =
          is_written && file->write_deep_image(PixelsOf(ldi.faces[i], ldi.sample_count, specs[i]));
    }
    const std::string why = is_written ? "" : file->geterror();
    return file->close() && is_written ? "" : absl::StrCat("OpenEXR: ", why);
  } catch (const std::exception& error) {
    return error.what();
  }
}

absl::Status CannotWrite(const std::filesystem::path& path, const std::string& why) {
  return absl::UnavailableError(absl::StrCat(path.string(), ": cannot be written: ", why));
}

absl::Status Unreadable(const std::filesystem::path& path, const std::string& why) {
  return absl::InvalidArgumentError(
      absl::StrCat(path.string(), ": found ", why, ", need a layered attenuation map's file"));
}

// nullopt in place of what is not as it should be.
bool ReadFace(OIIO::ImageInput& file, int part, uint32_t sample_count, LdiFace& face) {
  const OIIO::ImageSpec spec = file.spec(part);
  if (!spec.deep || spec.nchannels != kChannelCount || spec.channelnames[kDepth] != "Z") {
    return false;
  }
  OIIO::DeepData deep;
  if (!ReadView(spec.get_string_attribute(kView), face.view)) return false;
  if (!file.read_native_deep_image(part, 0, deep)) return false;
  face.view.width = static_cast<uint32_t>(spec.width);
  face.view.height = static_cast<uint32_t>(spec.height);
  face.offsets = {0};
  for (int64_t p = 0; p < deep.pixels(); ++p) {
    for (int k = 0; k < deep.samples(p); ++k) {
      const float seen = deep.deep_value(p, kAttenuation, k) * static_cast<float>(sample_count);
      if (!(seen >= 0 && seen <= static_cast<float>(sample_count))) return false;
      face.depths.push_back(deep.deep_value(p, kDepth, k));
      face.counts.push_back(static_cast<uint16_t>(std::lround(seen)));
    }
    face.offsets.push_back(static_cast<uint32_t>(face.depths.size()));
  }
  return true;
}

absl::StatusOr<AttenuationLdi> Read(const std::filesystem::path& path) {
  const std::unique_ptr<OIIO::ImageInput> file = OIIO::ImageInput::open(path.string());
  if (file == nullptr) return Unreadable(path, OIIO::geterror());
  const OIIO::ImageSpec first = file->spec(0);
  auto light = LightFromText(std::string(first.get_string_attribute(kLight)));
  if (!light.ok()) return Unreadable(path, "no light");
  const int samples = first.get_int_attribute(kSampleCount);
  if (samples < 1 || samples > UINT16_MAX) return Unreadable(path, "no number of samples");
  AttenuationLdi ldi{.light = *std::move(light),
                     .faces = {},
                     .sample_count = static_cast<uint32_t>(samples),
                     .tolerance = first.get_float_attribute(kTolerance, 1.0f)};
  for (int part = 0; file->seek_subimage(part, 0); ++part) {
    LdiFace face;
    if (!ReadFace(*file, part, ldi.sample_count, face)) {
      return Unreadable(path, absl::StrCat("a part that is no face: ", part));
    }
    ldi.faces.push_back(std::move(face));
  }
  return ldi;
}

}  // namespace

absl::Status WriteDeepExr(const std::filesystem::path& path, const AttenuationLdi& ldi) {
  if (ldi.faces.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path.string(), ": found a map without faces, need at least one"));
  }
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error)) {
    return CannotWrite(path, "it is no file");
  }
  // A link goes on leading to the file.
  std::filesystem::path target = std::filesystem::weakly_canonical(path, error);
  if (error) target = path;
  // Nobody else's, who may be writing the same file.
  const std::filesystem::path beside =
      absl::StrCat(target.string(), ".", std::random_device()(), ".part");
  std::string why = Write(beside, ldi);
  if (why.empty()) {
    std::filesystem::rename(beside, target, error);
    if (!error) return absl::OkStatus();
    why = error.message();
  }
  std::filesystem::remove(beside, error);
  return CannotWrite(path, why);
}

absl::StatusOr<AttenuationLdi> ReadDeepExr(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return absl::NotFoundError(absl::StrCat(path.string(), ": no such file"));
  }
  try {
    return Read(path);
  } catch (const std::exception& error) {
    return Unreadable(path, error.what());
  }
}

}  // namespace penumbra::openimageio
