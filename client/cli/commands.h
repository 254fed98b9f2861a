// What was asked for on the command line, one struct a subcommand; command_line.h fills them in and
// run_command.h acts on them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/cli/listings.h"
#include "client/cli/numbers.h"
#include "client/cli/people_commands.h"
#include "client/cli/scene_commands.h"
#include "client/display/volume_look.h"
#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/camera.h"
#include "render/scene/point_receiver.h"
#include "render/scene/receiver.h"
#include "render/technique/technique_params.h"

namespace penumbra {

// Pixels of a computed picture where nothing is said of them.
inline constexpr GridSize kPictureSize{512, 512};

// Points to compute shadows at, for techniques that take them.
struct PointRequest {
  std::vector<std::string> lightmaps;  // instances, each with its own texels
  std::filesystem::path file;          // of points with normals; empty: none
  std::optional<Camera> camera;        // of a picture; absent: one is chosen if nothing is named
  std::optional<GridSize> picture;     // the whole picture's pixels; absent: kPictureSize
  PixelRect crop;                      // of it; empty: all
  PixelRect first;                     // where to begin; empty: in the middle
};

// A scene file, and which of its shadows are wanted.
struct ShadowRequest {
  std::filesystem::path scene;
  std::vector<std::string> light_ids;  // lights of the file; "*": all of them
  bool adds_up_lights = false;         // "*" means one texture of them all, not one of each
  std::vector<AreaLight> lights;       // lights given as numbers
  std::vector<Parallelogram> receivers;
  std::vector<std::string> receiver_instances;
  bool floor = false;
  std::optional<GridSize> texels;        // of each receiver; absent: GridSize's own
  std::string texels_option = "--size";  // that they are given by
  Vec3 reflectance{1.0f};                // of every receiver
  // A receiver on each planar surface of the file instead, with a grid by its size.
  bool every_polygon = false;
  double min_area_m2 = 0.0;
  float texels_per_metre = 0.0f;  // 0: the largest surface's longer edge gets 256 texels
  PointRequest points;
  TechniqueParams params;
};

struct BakeCommand {
  EngineChoice engine;
  ShadowRequest request;
  std::filesystem::path out;
  std::optional<float> exposure;  // absent: chosen (WriteBake)
  bool json = false;
};

struct ViewCommand {
  EngineChoice engine;
  std::string scene_id;      // of the server's scene that is drawn in place of the request's file
  std::string follow;        // whose camera, by name or id; empty: nobody's
  PersonChoice person;       // who follows
  bool watch = false;        // draws again whenever something changes
  bool until_left = false;   // watches no longer than whom it follows is there
  double max_seconds = 0.0;  // of watching, or of waiting for a camera to follow; 0: not said
  ShadowRequest request;
  std::optional<uint32_t> max_planar_receivers;  // absent: 4
  std::optional<Camera> camera;  // absent: the file's first one, or one that sees everything
  GridSize size{960, 640};
  std::filesystem::path out;
  // With the final picture's shadows in place of the textures': radiance in float32, as half floats
  // go up to 65,504 only, whatever the light's strength.
  bool final = false;
  TechniqueParams final_params = CoherentRaytraceParams{.output = RadianceFormat::kFloat32};
  bool has_final_settings = false;        // some of them were given for it alone
  std::optional<Vec3> ambient;            // absent: a share of the light there is
  std::optional<float> exposure;          // absent: found from the picture
  std::optional<VolumeLook> volume_look;  // some of it was given
  std::string volume_option;              // the last one that did
  bool has_volume_opacity = false;
  bool culls_back_faces = false;
  bool json = false;
};

struct PushCommand {
  EngineChoice engine;
  PersonChoice person;
  ShadowRequest request;  // without parameters
  std::string scene_id;
  bool json = false;
};

struct WatchCommand {
  EngineChoice engine;
  std::string scene_id;
  std::vector<std::string> light_ids;     // empty: every light of the scene
  std::vector<std::string> receiver_ids;  // empty: every receiver of the scene
  TechniqueParams params;
  float time_budget_ms = 0;         // 0: none
  std::optional<Camera> camera;     // what is looked at; absent: nothing
  std::optional<GridSize> picture;  // pixels, of a technique that computes one
  uint64_t max_updates = 0;         // 0: until interrupted
  double max_seconds = 0.0;         // 0: until interrupted
  bool until_final = false;         // every shadow was final once
  bool json = false;
};

struct ReceiversCommand {
  std::filesystem::path scene;
  double min_area_m2 = 0.0;
  uint32_t count = 20;            // of the largest; 0: all
  float texels_per_metre = 0.0f;  // as in ShadowRequest
  bool json = false;
};

struct DemoCommand {
  EngineChoice engine;
  std::filesystem::path scene;
  std::filesystem::path out;
  std::optional<GridSize> texels;
  GridSize size{960, 640};
  TechniqueParams params;
};

// Help or a version was asked for.
struct PrintText {
  std::string text;
};

using Command =
    std::variant<PrintText, BakeCommand, ViewCommand, PushCommand, WatchCommand, TechniquesCommand,
                 InfoCommand, TopCommand, DemoCommand, ReceiversCommand, WhoCommand, EditCommand,
                 EditControlCommand, ScenesListCommand, ScenesExportCommand, ScenesImportCommand,
                 ScenesDeleteCommand, ScenesDiffCommand, ReplayCommand>;

}  // namespace penumbra
