// Commands that work with a server, or ask what there is.
#include <string>

#include "client/cli/grammar.h"
#include "client/cli/option_values.h"

namespace penumbra {

void Grammar::AddPushAndWatch() {
  CLI::App* push = AddCommand(push_, "push", "Make a server's scene equal to a file");
  AddRequest(push, push_.request, "--size");
  AddEngine(push, push_.engine, true);
  AddSceneId(push, push_.scene_id, "The server's scene; made if there is none");
  AddPerson(push, push_.person);
  AddEditing(push, push_.person);
  push->add_flag("--json", push_.json, "Print what was sent as JSON");

  CLI::App* watch = AddCommand(watch_, "watch", "Print each update of a server's scene");
  AddEngine(watch, watch_.engine, true);
  AddSceneId(watch, watch_.scene_id, "The server's scene");
  AddTechnique(watch, watch_.params);
  watch
      ->add_option("--light", watch_.light_ids,
                   "A light (default: each of them). *: all of them in one texture")
      ->allow_extra_args(false)
      ->type_name("ID");
  watch->add_option("--receiver", watch_.receiver_ids, "A receiver (default: all)")
      ->allow_extra_args(false)
      ->type_name("ID");
  Add(watch, "--time-budget", "MS",
      "How soon after a commit its first artifact should be there, with as many samples as fit, "
      "at least one, and 8 until it is known what they take (default: always 8)",
      [this](const std::string& text) { return SetTimeBudget(text, watch_.time_budget_ms); });
  Add(watch, "--camera", "\"eye target [up] [fov_deg]\"",
      "What is looked at: receivers that fill more of the picture come first",
      [this](const std::string& text) { return SetCamera(text, watch_.camera); });
  AddTo(watch, "--picture", kSizeForm,
        "Pixels of the picture that coherent_raytrace computes for the camera (default 512x512)",
        watch_.picture, ReadPixels);
  Add(watch, "--updates", "N", "Stop after N updates",
      [this](const std::string& text) { return SetUpdates(text, watch_.max_updates); });
  Add(watch, "--seconds", "S", "Stop after a time",
      [this](const std::string& text) { return SetSeconds(text, watch_.max_seconds); });
  watch->add_flag("--until-final", watch_.until_final,
                  "Stop once every shadow is there with all its samples");
  watch->add_flag("--json", watch_.json, "One JSON object a line");
}

void Grammar::AddListings() {
  CLI::App* techniques = AddCommand(techniques_, "techniques", "List the techniques");
  AddEngine(techniques, techniques_.engine);
  techniques->add_flag("--json", techniques_.json, "Print JSON");
  CLI::App* info = AddCommand(info_, "info", "Say what this program, or a server, is and can do");
  AddEngine(info, info_.engine);
  info->add_flag("--json", info_.json, "Print JSON");
  CLI::App* top =
      AddCommand(top_, "top", "Show what goes on at a server: scenes, clients, jobs, rates");
  AddEngine(top, top_.engine, true);
  top->add_option("--rows", top_.rows, "The most scenes, and clients, to show (default 20)")
      ->check(CLI::Range(1, 100'000))
      ->type_name("N");
  Add(top, "--interval", "S", "Seconds between looks (default 1)", [this](const std::string& text) {
    return SetWithin("--interval", text, 0.1, 3600.0, top_.interval_s);
  });
  top->add_flag("--once", top_.once, "Show one table, and end");
  top->add_flag("--json", top_.json, "What the server says, one JSON object a line");
}

void Grammar::AddDemo() {
  CLI::App* app =
      AddCommand(demo_, "demo", "Stream a scene to a server, edit it, draw the results");
  AddScene(app, demo_.scene);
  AddEngine(app, demo_.engine, true);
  AddTechnique(app, demo_.params);
  app->add_option("--out", demo_.out, "Folder for the pictures")->type_name("DIR")->required();
  AddTo(app, "--texture-size", kSizeForm, "Texels of each receiver (default 256x256)", demo_.texels,
        ReadTexels);
  AddTo(app, "--size", kSizeForm, "Pixels of the pictures (default 960x640)", demo_.size,
        ReadPixels);
}

}  // namespace penumbra
