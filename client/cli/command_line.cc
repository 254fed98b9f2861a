#include "client/cli/command_line.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "CLI/App.hpp"
#include "CLI/Config.hpp"
#include "CLI/Formatter.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/cli/grammar.h"
#include "client/cli/light_option.h"
#include "client/cli/option_error.h"
#include "client/cli/option_values.h"
#include "client/cli/parameter_option.h"
#include "client/cli/shading_options.h"
#include "client/cli/version.h"

namespace penumbra {
namespace {

constexpr char kExamples[] =
    "Numbers may be separated by commas or blanks. Lengths are metres, +Y is up.\n"
    "Exit status 0: done; 1: it failed; 2: the command line by itself makes no sense.\n"
    "Try: penumbra bake table.glb --floor --out shadows";

}  // namespace

CLI::Option* Grammar::Add(CLI::App* app, const char* name, const std::string& form,
                          const char* help, Read read) {
  const auto read_it = [this, read](const std::string& text) { error_.Update(read(text)); };
  return app->add_option_function<std::string>(name, read_it, help)->type_name(form);
}

CLI::Option* Grammar::AddRepeated(CLI::App* app, const char* name, const std::string& form,
                                  const char* help, Read read) {
  const auto read_all = [this, read](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) error_.Update(read(text));
  };
  return app->add_option_function<std::vector<std::string>>(name, read_all, help)
      ->allow_extra_args(false)
      ->type_name(form);
}

void Grammar::AddEngine(CLI::App* app, EngineChoice& engine, bool server_is_required) {
  Add(app, "--server", "HOST:PORT", "Compute on the server at this address",
      [&engine](const std::string& text) { return SetServer(text, engine.server); })
      ->required(server_is_required);
  AddCredentials(app, engine);
}

void Grammar::AddScene(CLI::App* app, std::filesystem::path& scene) {
  app->add_option("SCENE", scene, "A glTF, GLB, OBJ or PLY file")->type_name("FILE")->required();
}

void Grammar::AddTechnique(CLI::App* app, TechniqueParams& params, TechniqueParams* also) {
  const auto set_both = [&params, also](absl::Status (*set)(TechniqueParams&, std::string_view)) {
    return [&params, also, set](const std::string& text) {
      const absl::Status status = set(params, text);
      return status.ok() && also ? set(*also, text) : status;
    };
  };
  Add(app, "--technique", "NAME", "How shadows are computed (default soft_texture)",
      [&params, also](const std::string& text) {
        const auto technique = ReadTechnique("--technique", text);
        if (!technique.ok()) return technique.status();
        params = also && also->index() == technique->index() ? *also : *technique;
        return absl::OkStatus();
      });
  AddRepeated(app, "--set", "NAME=VALUE",
              "A parameter of the technique, as `techniques` lists them",
              [&params](const std::string& text) { return SetParameter("--set", params, text); });
  Add(app, "--samples", "N",
      "Samples on each light that has a size (default 64; coherent_raytrace 256)",
      set_both(&SetSamples));
  Add(app, "--seed", "N", "Of the samples' jitter: the same seed gives the same bits (default 1)",
      set_both(&SetSeed));
  Add(app, "--method", "NAME",
      "How hard shadows are drawn: auto, coverage, edge_flag, silhouette or gl; all give the same "
      "counts, but gl within rounding of an edge (default auto)",
      [&params](const std::string& text) { return SetMethod(params, text); });
  for (const ShadingOption& o : ShadingOptions()) {
    Add(app, o.name, o.form, o.help, [&](const std::string& text) { return o.set(params, text); });
  }
}

void Grammar::AddLights(CLI::App* app, ShadowRequest& request) {
  app->add_option("--light", request.light_ids,
                  absl::StrCat("A light of the scene; default: all of them. If any light is named "
                               "or given as numbers, only those shine. *: all of them",
                               request.adds_up_lights ? ", in one texture" : ""))
      ->allow_extra_args(false)
      ->type_name("ID");
  for (const LightOption& option : LightOptions()) {
    AddRepeated(app, option.name, absl::StrCat("\"", option.form, "\""), option.help,
                [&request, &option](const std::string& text) {
                  return AddLight(option, text, request.lights);
                });
  }
}

void Grammar::AddRequest(CLI::App* app, ShadowRequest& request, const char* size_name) {
  AddScene(app, request.scene);
  AddLights(app, request);
  AddRepeated(app, "--receiver", "\"origin edge_u edge_v\"",
              "A patch to receive shadows, lit on both sides",
              [&request](const std::string& text) { return AddReceiver(text, request.receivers); });
  app->add_option("--receiver-instance", request.receiver_instances,
                  "A flat instance of the scene to receive shadows")
      ->allow_extra_args(false)
      ->type_name("ID");
  app->add_flag("--floor", request.floor,
                "A patch under the scene, three times as wide and as deep, to receive shadows");
  CLI::Option* every =
      app->add_flag("--every-polygon", request.every_polygon,
                    "Every planar surface of the scene receives shadows on a grid by its size");
  AddSurfaces(app, request.min_area_m2, request.texels_per_metre, every);
  request.texels_option = size_name;
  AddTo(app, size_name, kSizeForm, "Texels of each other receiver (default 256x256)",
        request.texels, ReadTexels);
  AddTo(app, "--reflectance", "\"r g b\"", "Of the receivers, 0 to 1 (default 1; in a view 0.8)",
        request.reflectance, ReadReflectance);
}

void Grammar::AddSurfaces(CLI::App* app, double& min_area_m2, float& texels_per_metre,
                          CLI::Option* only_with) {
  CLI::Option* area =
      Add(app, "--min-area", "M2", "Leave out planar surfaces of less, in square metres",
          [&min_area_m2](const std::string& text) { return SetArea(text, min_area_m2); });
  CLI::Option* density = Add(
      app, "--texels-per-metre", "D",
      "Of the grids of planar surfaces, to the next power of two, 16 to 256 a side (default: the "
      "largest surface's longer side gets 256)",
      [&texels_per_metre](const std::string& text) { return SetDensity(text, texels_per_metre); });
  if (!only_with) return;
  area->needs(only_with);
  density->needs(only_with);
}

void Grammar::AddPoints(CLI::App* app, PointRequest& points) {
  app->add_option("--lightmap", points.lightmaps,
                  "Of coherent_raytrace: an instance whose texture coordinates get --size texels")
      ->allow_extra_args(false)
      ->type_name("ID");
  app->add_option("--points", points.file,
                  "Of coherent_raytrace: points with normals, six numbers a line")
      ->type_name("FILE");
  Add(app, "--camera", "\"eye target [up] [fov_deg]\"",
      "Of coherent_raytrace: where its picture is taken from (default: the file's camera, or all "
      "in sight)",
      [&points](const std::string& text) { return SetCamera(text, points.camera); });
  AddTo(app, "--picture", kSizeForm, "Pixels of its picture (default 512x512)", points.picture,
        ReadPixels);
  AddTo(app, "--crop", "\"x y width height\"", "The part of the picture that is wanted, in pixels",
        points.crop, ReadRect);
  AddTo(app, "--first", "\"x y width height\"", "Where in the picture to begin", points.first,
        ReadRect);
}

void Grammar::AddThreads(CLI::App* app, EngineChoice& engine) {
  app->add_option("--threads", engine.threads,
                  "Without a server: threads to compute on (default 0: one for each processor)")
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
}

void Grammar::AddSceneId(CLI::App* app, std::string& scene_id, const char* help) {
  Add(app, "--scene", "ID", help, [&scene_id](const std::string& text) {
    return SetSceneId("--scene", text, scene_id);
  })->required();
}

void Grammar::AddReceivers() {
  CLI::App* app = AddCommand(receivers_, "receivers", "List the planar surfaces of a scene");
  AddScene(app, receivers_.scene);
  AddSurfaces(app, receivers_.min_area_m2, receivers_.texels_per_metre);
  Add(app, "--count", "N", "How many of the largest; 0: all (default 20)",
      [this](const std::string& text) { return SetCount("--count", text, receivers_.count); });
  app->add_flag("--json", receivers_.json, "Print JSON");
}

void Grammar::AddBake() {
  CLI::App* app = AddCommand(bake_, "bake", "Write the soft shadows of a scene to files");
  bake_.request.adds_up_lights = true;
  AddRequest(app, bake_.request, "--size");
  AddTechnique(app, bake_.request.params);
  AddPoints(app, bake_.request.points);
  AddEngine(app, bake_.engine);
  AddThreads(app, bake_.engine);
  app->add_option("--out", bake_.out,
                  "Folder for NAME.exr, NAME.png and NAME.json, and of shadow volumes meshes")
      ->type_name("DIR")
      ->required();
  Add(app, "--exposure", "FACTOR",
      "Radiance that is 1/FACTOR is white in the PNG (default: the largest; of coherent_raytrace "
      "from the picture)",
      [this](const std::string& text) { return SetExposure(text, bake_.exposure); });
  app->add_flag("--json", bake_.json, "Print what was written as JSON");
}

Grammar::Grammar() {
  app_.require_subcommand(1);
  app_.footer(kExamples);
  app_.set_version_flag("--version", VersionText());
  AddBake();
  AddView();
  AddPushAndWatch();
  AddListings();
  AddDemo();
  AddReceivers();
  AddScenes();
  AddPeople();
  AddEditControl();
}

// Words that are no command, as far as nothing but commands was said before them.
absl::Status Grammar::CheckCommandNames(const std::vector<std::string>& arguments) const {
  const CLI::App* app = &app_;
  for (const std::string& word : arguments) {
    std::vector<std::string> names;
    for (const CLI::App* command : app->get_subcommands([](const CLI::App*) { return true; })) {
      names.push_back(command->get_name());
    }
    if (names.empty() || word.starts_with('-')) break;
    if (std::ranges::count(names, word) == 0) {
      return OptionError(app == &app_ ? "command" : app->get_name(), "UNKNOWN_COMMAND", {word},
                         absl::StrCat(", need one of: ", absl::StrJoin(names, ", ")));
    }
    app = app->get_subcommand(word);
  }
  return absl::OkStatus();
}

absl::StatusOr<Command> Grammar::Parse(const std::vector<std::string>& arguments) {
  if (auto status = CheckCommandNames(arguments); !status.ok()) return status;
  std::vector<std::string> reversed = TieNumbersToOptions(arguments);
  std::reverse(reversed.begin(), reversed.end());
  try {
    app_.parse(std::move(reversed));
  } catch (const CLI::CallForHelp&) {
    const auto chosen = app_.get_subcommands();
    return PrintText{(chosen.empty() ? &app_ : chosen.front())->help()};
  } catch (const CLI::CallForVersion& version) {
    return PrintText{absl::StrCat(version.what(), "\n")};
  } catch (const CLI::ParseError& error) {
    if (!error_.ok()) return error_;
    return absl::InvalidArgumentError(
        absl::StrCat(OneLine(error.what()), " (run with --help for more)"));
  }
  if (!error_.ok()) return error_;
  return chosen_;
}

absl::StatusOr<Command> ParseCommandLine(const std::vector<std::string>& arguments) {
  return Grammar().Parse(arguments);
}

}  // namespace penumbra
