#include "client/display/image_module.h"

#include "client/display/openimageio/images.h"

extern "C" __attribute__((visibility("default")))
const penumbra::ImageModule penumbra_image_module = {
    .write_png = penumbra::openimageio::WritePng,
    .write_exr = penumbra::openimageio::WriteExr,
    .read_image = penumbra::openimageio::ReadImage,
    .write_deep_exr = penumbra::openimageio::WriteDeepExr,
    .read_deep_exr = penumbra::openimageio::ReadDeepExr};
