// The command that draws, and how it does.
#include <string>

#include "client/cli/grammar.h"
#include "client/cli/option_values.h"
#include "client/cli/parameter_option.h"

namespace penumbra {

void Grammar::AddVolumeLook(CLI::App* app) {
  const auto look = [this](const char* option) -> VolumeLook& {
    view_.volume_option = option;
    if (!view_.volume_look) view_.volume_look.emplace();
    return *view_.volume_look;
  };
  Add(app, "--volume-shading", "NAME",
      "Of shadow_volume: ambient, each light where it is seen; composited, shadows darkened; or "
      "black (default ambient)",
      [look](const std::string& text) {
        return SetVolumeShading(text, look("--volume-shading").shading);
      });
  Add(app, "--volume-opacity", "SHARE", "How dark composited shadows are (default 0.5)",
      [this, look](const std::string& text) {
        view_.has_volume_opacity = true;
        return SetVolumeOpacity(text, look("--volume-opacity").opacity);
      });
  Add(app, "--volume-passes", "N",
      "Of shadow_volume: 1 to 64 drawings, each a little turned, that smooth edges (default 1)",
      [look](const std::string& text) {
        return SetVolumePasses(text, look("--volume-passes").passes);
      });
}

void Grammar::AddView() {
  CLI::App* app = AddCommand(view_, "view", "Draw a scene with its soft shadows");
  // As instances are where their file says nothing, so that a patch does not outshine them.
  view_.request.reflectance = Vec3(0.8f);
  AddRequest(app, view_.request, "--texture-size");
  AddTechnique(app, view_.request.params, &view_.final_params);
  AddEngine(app, view_.engine);
  AddThreads(app, view_.engine);
  app->add_option("--receivers", view_.max_planar_receivers,
                  "How many flat instances receive shadows where none is named (default 4)")
      ->type_name("N");
  Add(app, "--camera", "\"eye target [up] [fov_deg]\"",
      "Where the picture is taken from (default: the file's camera, or all in sight)",
      [this](const std::string& text) { return SetCamera(text, view_.camera); });
  AddTo(app, "--size", kSizeForm, "Pixels of the picture (default 960x640)", view_.size,
        ReadPixels);
  app->add_option("--out", view_.out, "The picture, .png or .exr")->type_name("FILE")->required();
  CLI::Option* final =
      app->add_flag("--final", view_.final,
                    "Then trace the final picture's shadows (coherent_raytrace) and show these, "
                    "with the --samples and the --seed given");
  AddRepeated(app, "--final-set", "NAME=VALUE",
              "A parameter of coherent_raytrace for --final; --set is for the technique before it",
              [this](const std::string& text) {
                view_.has_final_settings = true;
                return SetParameter("--final-set", view_.final_params, text);
              })
      ->needs(final);
  Add(app, "--ambient", "\"r g b\"",
      "Radiance that reaches every surface (default: a share of the light there is)",
      [this](const std::string& text) { return SetAmbient(text, view_.ambient); });
  app->add_flag("--cull-back-faces", view_.culls_back_faces,
                "Leave out faces that turn away, to see into closed rooms; not of traced ones");
  AddVolumeLook(app);
  Add(app, "--exposure", "FACTOR",
      "What radiance is multiplied by in a PNG (default: from the picture)",
      [this](const std::string& text) { return SetExposure(text, view_.exposure); });
  app->add_flag("--json", view_.json, "Print what was drawn as JSON");
  AddViewedScene(app);
}

// In place of a file. What makes a scene of a file has no use then.
void Grammar::AddViewedScene(CLI::App* app) {
  CLI::Option* scene =
      Add(app, "--scene", "ID", "Draw this scene of the server's, with its lights and receivers",
          [this](const std::string& text) { return SetSceneId("--scene", text, view_.scene_id); });
  scene->needs(app->get_option("--server"));
  for (const char* name : {"SCENE", "--receiver", "--receiver-instance", "--floor",
                           "--every-polygon", "--texture-size", "--reflectance", "--receivers"}) {
    scene->excludes(app->get_option(name));
  }
  for (const LightOption& option : LightOptions()) scene->excludes(app->get_option(option.name));
  app->get_option("SCENE")->required(false);
  CLI::Option* follow =
      app->add_option("--follow", view_.follow,
                      "Look through the camera of somebody in the --scene, by name or id")
          ->type_name("NAME");
  follow->needs(scene)->excludes(app->get_option("--camera"));
  CLI::Option* watch =
      app->add_flag("--watch", view_.watch,
                    "Draw the --scene again whenever it or the camera changes, until interrupted");
  watch->needs(scene);
  app->add_flag("--until-left", view_.until_left,
                "With --watch and --follow: end when they leave; else their last camera stays")
      ->needs(watch)
      ->needs(follow);
  Add(app, "--seconds", "S",
      "How long to --watch (default: until interrupted) or to wait for a camera to --follow "
      "(default 10)",
      [this](const std::string& text) { return SetSeconds(text, view_.max_seconds); })
      ->needs(scene);
  AddPerson(app, view_.person);
}

}  // namespace penumbra
