#include "client/cli/point_plan.h"

#include <algorithm>
#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/draw_scene.h"
#include "client/cli/numbers.h"
#include "client/cli/option_error.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status CheckAs(const char* option, const PointReceiver& receiver) {
  return OfOption(option, Check(receiver));
}

absl::StatusOr<PlannedPoints> PlanLightmap(const ImportedScene& imported,
                                           const ShadowRequest& request, const std::string& id) {
  std::vector<std::string> ids;
  for (const Instance& instance : imported.instances) ids.push_back(instance.id);
  if (std::ranges::count(ids, id) == 0) return UnknownIdError("--lightmap", id, std::move(ids));
  const GridSize texels = request.texels.value_or(GridSize{});
  LightmapTexels lightmap{id, texels.width, texels.height};
  if (auto status = CheckAs("--lightmap", lightmap); !status.ok()) return status;
  return PlannedPoints{id, std::move(lightmap)};
}

}  // namespace

absl::StatusOr<GivenPoints> ReadPoints(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) return absl::NotFoundError(absl::StrCat("--points: no such file: ", path.string()));
  auto points = std::make_shared<std::vector<SurfacePoint>>();
  std::string line;
  for (size_t number = 1; std::getline(file, line); ++number) {
    line.resize(std::min(line.size(), line.find('#')));
    if (line.find_first_not_of(" \t\r,") == std::string::npos) continue;
    const std::string where = absl::StrCat(path.string(), ":", number);
    const auto numbers = ParseNumbers(where, line);
    if (!numbers.ok()) return numbers.status();
    if (numbers->size() != 6) {
      return FieldError(
          absl::StatusCode::kInvalidArgument, "NUMBER_COUNT", where,
          absl::StrCat("found ", numbers->size(), " numbers, need 6: a position and a normal"));
    }
    points->push_back({Vec3At(*numbers, 0), Vec3At(*numbers, 3)});
    if (points->size() > kMaxGivenPoints) break;  // which is refused, with the number that is not
  }
  GivenPoints given{std::move(points)};
  if (auto status = CheckAs("--points", given); !status.ok()) return status;
  return given;
}

absl::StatusOr<std::vector<PlannedPoints>> PlanPoints(const ImportedScene& imported,
                                                      const ShadowRequest& request) {
  const PointRequest& wanted = request.points;
  std::vector<PlannedPoints> planned;
  for (const std::string& id : wanted.lightmaps) {
    auto lightmap = PlanLightmap(imported, request, id);
    if (!lightmap.ok()) return lightmap.status();
    planned.push_back(*std::move(lightmap));
  }
  if (!wanted.file.empty()) {
    auto given = ReadPoints(wanted.file);
    if (!given.ok()) return given.status();
    planned.push_back({"points", *std::move(given)});
  }
  const bool names_picture =
      wanted.camera || wanted.picture || !wanted.crop.empty() || !wanted.first.empty();
  if (!planned.empty() && !names_picture) return planned;
  const GridSize size = wanted.picture.value_or(kPictureSize);
  PicturePixels picture{
      .camera = wanted.camera.value_or(ChooseCamera(imported, request.floor, size)),
      .width = size.width,
      .height = size.height,
      .crop = wanted.crop,
      .first = wanted.first};
  if (auto status = CheckAs("--picture", picture); !status.ok()) return status;
  planned.push_back({"picture", std::move(picture)});
  return planned;
}

}  // namespace penumbra
