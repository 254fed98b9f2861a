#include "proto/convert/points_convert.h"

#include <bit>
#include <cstring>
#include <string>
#include <utility>

#include "proto/convert/geometry_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

static_assert(std::endian::native == std::endian::little, "points are copied as they lie");
static_assert(sizeof(Vec3) == 12);

v1::PixelRect ToProto(const PixelRect& rect) {
  v1::PixelRect proto;
  proto.set_x(rect.x);
  proto.set_y(rect.y);
  proto.set_width(rect.width);
  proto.set_height(rect.height);
  return proto;
}

PixelRect FromProto(const v1::PixelRect& proto) {
  return {proto.x(), proto.y(), proto.width(), proto.height()};
}

// One overload of Write a kind: a new one does not compile without.
void Write(const PicturePixels& picture, v1::PointReceiver& proto) {
  auto& kind = *proto.mutable_picture();
  *kind.mutable_camera() = penumbra::ToProto(View{picture.camera, picture.aspect()});
  kind.set_width(picture.width);
  kind.set_height(picture.height);
  if (picture.crop != PixelRect{}) *kind.mutable_crop() = ToProto(picture.crop);
  if (picture.first != PixelRect{}) *kind.mutable_first() = ToProto(picture.first);
}

void Write(const LightmapTexels& lightmap, v1::PointReceiver& proto) {
  proto.mutable_lightmap()->set_instance_id(lightmap.instance_id);
  proto.mutable_lightmap()->set_width(lightmap.width);
  proto.mutable_lightmap()->set_height(lightmap.height);
}

void Write(const GivenPoints& given, v1::PointReceiver& proto) {
  std::string& positions = *proto.mutable_given()->mutable_positions();
  std::string& normals = *proto.mutable_given()->mutable_normals();
  positions.resize(given.size() * sizeof(Vec3));
  normals.resize(given.size() * sizeof(Vec3));
  for (size_t i = 0; i < given.size(); ++i) {
    const SurfacePoint& point = (*given.points)[i];
    std::memcpy(&positions[i * sizeof(Vec3)], &point.position, sizeof(Vec3));
    std::memcpy(&normals[i * sizeof(Vec3)], &point.normal, sizeof(Vec3));
  }
}

absl::Status WrongLength(const char* field, size_t found, const std::string& need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", field,
                    "found " + std::to_string(found) + " bytes, need " + need);
}

absl::StatusOr<PointReceiver> Read(const v1::GivenPoints& proto) {
  const size_t bytes = proto.positions().size();
  if (bytes % sizeof(Vec3) != 0) {
    return WrongLength("given.positions", bytes, "12 for each point");
  }
  if (proto.normals().size() != bytes) {
    return WrongLength("given.normals", proto.normals().size(), std::to_string(bytes));
  }
  auto points = std::make_shared<std::vector<SurfacePoint>>(bytes / sizeof(Vec3));
  for (size_t i = 0; i < points->size(); ++i) {
    std::memcpy(&(*points)[i].position, &proto.positions()[i * sizeof(Vec3)], sizeof(Vec3));
    std::memcpy(&(*points)[i].normal, &proto.normals()[i * sizeof(Vec3)], sizeof(Vec3));
  }
  return GivenPoints{std::move(points)};
}

PicturePixels Read(const v1::PicturePixels& proto) {
  return {.camera = CameraFromProto(proto.camera()),
          .width = proto.width(),
          .height = proto.height(),
          .crop = FromProto(proto.crop()),
          .first = FromProto(proto.first())};
}

}  // namespace

v1::PointReceiver ToProto(const PointReceiver& receiver) {
  v1::PointReceiver proto;
  std::visit([&](const auto& one) { Write(one, proto); }, receiver);
  return proto;
}

absl::StatusOr<PointReceiver> FromProto(const v1::PointReceiver& proto) {
  switch (proto.points_case()) {
    case v1::PointReceiver::kPicture:
      return Read(proto.picture());
    case v1::PointReceiver::kLightmap:
      return LightmapTexels{proto.lightmap().instance_id(), proto.lightmap().width(),
                            proto.lightmap().height()};
    case v1::PointReceiver::kGiven:
      return Read(proto.given());
    case v1::PointReceiver::POINTS_NOT_SET:
      break;
  }
  return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "points",
                    "found none that this program knows, need a picture, a lightmap or points");
}

}  // namespace penumbra
