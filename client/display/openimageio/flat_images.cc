#include <OpenImageIO/imageio.h>

#include <exception>
#include <memory>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "client/display/openimageio/images.h"

namespace penumbra::openimageio {
namespace {

absl::Status CannotWrite(const std::filesystem::path& path, const std::string& why) {
  return absl::UnavailableError(absl::StrCat(path.string(), ": cannot be written: ", why));
}

// Writes all or leaves nothing. OpenImageIO may throw when memory ends.
absl::Status WriteWhole(const std::filesystem::path& path, const char* format,
                        const OIIO::ImageSpec& spec, const void* pixels) {
  bool is_open = false;
  std::string why;
  try {
    // By format and not by the path's ending, which is the caller's business.
    const std::unique_ptr<OIIO::ImageOutput> file = OIIO::ImageOutput::create(format);
    if (file == nullptr) return CannotWrite(path, OIIO::geterror());
    is_open = file->open(path.string(), spec);
    const bool is_written = is_open && file->write_image(spec.format, pixels);
    const bool is_closed = is_open && file->close();
    if (is_written && is_closed) return absl::OkStatus();
    why = file->geterror();
  } catch (const std::exception& error) {
    why = error.what();
  }
  std::error_code ignored;
  if (is_open) std::filesystem::remove(path, ignored);
  return CannotWrite(path, why);
}

absl::Status CheckSize(const std::filesystem::path& path, int width, int height, size_t found,
                       size_t channels, std::string_view what) {
  if (width <= 0 || height <= 0) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ": found ", width, " × ", height,
                                                   " pixels, need at least 1 × 1"));
  }
  const size_t needed = channels * static_cast<size_t>(width) * static_cast<size_t>(height);
  if (found == needed) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(path.string(), ": ",
                                                 absl::string_view(what.data(), what.size()),
                                                 ": found ", found, " values, need ", needed));
}

absl::Status Unreadable(const std::filesystem::path& path, const std::string& why) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return absl::NotFoundError(absl::StrCat(path.string(), ": no such file"));
  }
  return absl::InvalidArgumentError(absl::StrCat(path.string(), ": cannot be read: ", why));
}

absl::StatusOr<Planes> ReadPlanes(const std::filesystem::path& path) {
  const std::unique_ptr<OIIO::ImageInput> file = OIIO::ImageInput::open(path.string());
  if (file == nullptr) return Unreadable(path, OIIO::geterror());
  const OIIO::ImageSpec& spec = file->spec();
  Planes planes = {.width = spec.width, .height = spec.height, .values = {}};
  const size_t texels = spec.image_pixels();
  std::vector<float> interleaved(texels * spec.nchannels);
  if (!file->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, interleaved.data())) {
    return Unreadable(path, file->geterror());
  }
  for (int c = 0; c < spec.nchannels; ++c) {
    std::vector<float>& plane = planes.values[spec.channelnames[c]];
    plane.resize(texels);
    for (size_t i = 0; i < texels; ++i) plane[i] = interleaved[i * spec.nchannels + c];
  }
  return planes;
}

}  // namespace

absl::Status WritePng(const std::filesystem::path& path, int width, int height,
                      std::span<const uint8_t> rgb) {
  if (absl::Status status = CheckSize(path, width, height, rgb.size(), 3, "rgb"); !status.ok()) {
    return status;
  }
  OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  return WriteWhole(path, "png", spec, rgb.data());
}

absl::Status WriteExr(const std::filesystem::path& path, int width, int height,
                      std::span<const NamedPlane> planes) {
  if (planes.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(path.string(), ": found no channel, need one"));
  }
  OIIO::ImageSpec spec(width, height, static_cast<int>(planes.size()), OIIO::TypeDesc::FLOAT);
  spec.channelnames.clear();
  for (const NamedPlane& plane : planes) {
    if (absl::Status status = CheckSize(path, width, height, plane.values.size(), 1, plane.name);
        !status.ok()) {
      return status;
    }
    spec.channelnames.push_back(plane.name);
    spec.channelformats.emplace_back(plane.half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
  }
  spec.attribute("compression", "zip");
  // OpenImageIO would write the time: the same texels are to be the same bytes.
  spec.attribute("DateTime", "1970:01:01 00:00:00");
  spec.attribute("oiio:ColorSpace", "Linear");
  const size_t texels = planes[0].values.size();
  std::vector<float> interleaved(texels * planes.size());
  for (size_t c = 0; c < planes.size(); ++c) {
    for (size_t i = 0; i < texels; ++i) interleaved[i * planes.size() + c] = planes[c].values[i];
  }
  return WriteWhole(path, "openexr", spec, interleaved.data());
}

absl::StatusOr<Planes> ReadImage(const std::filesystem::path& path) {
  try {
    return ReadPlanes(path);
  } catch (const std::exception& error) {
    return Unreadable(path, error.what());
  }
}

}  // namespace penumbra::openimageio
