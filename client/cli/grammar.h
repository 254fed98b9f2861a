// The commands and their options, as the argument parser knows them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "CLI/App.hpp"
#include "absl/status/statusor.h"
#include "client/cli/commands.h"

namespace penumbra {

// How a size may be given.
inline constexpr char kSizeForm[] = "SIDE|WIDTHxHEIGHT";

// The parser, and the first thing that our own readers of values found wrong.
class Grammar {
 public:
  Grammar();

  absl::StatusOr<Command> Parse(const std::vector<std::string>& arguments);

 private:
  template <typename C>
  CLI::App* AddCommand(C& command, const char* name, const char* summary,
                       CLI::App* parent = nullptr);
  void AddEngine(CLI::App* app, EngineChoice& engine, bool server_is_required = false);
  void AddCredentials(CLI::App* app, EngineChoice& engine);
  void AddScene(CLI::App* app, std::filesystem::path& scene);
  void AddRequest(CLI::App* app, ShadowRequest& request, const char* size_name);
  void AddLights(CLI::App* app, ShadowRequest& request);
  // Samples and a seed are given to `also` too, whose values are the defaults of its technique.
  void AddTechnique(CLI::App* app, TechniqueParams& params, TechniqueParams* also = nullptr);
  void AddPoints(CLI::App* app, PointRequest& points);
  void AddBake();
  void AddView();
  void AddVolumeLook(CLI::App* app);
  void AddPushAndWatch();
  void AddListings();
  // Who the user is to others; and what makes them the only one who edits.
  void AddPerson(CLI::App* app, PersonChoice& person);
  void AddEditing(CLI::App* app, PersonChoice& person);
  void AddPeople();
  void AddEditControl();
  void AddViewedScene(CLI::App* app);
  void AddDemo();
  void AddReceivers();
  void AddScenes();
  void AddArchives(CLI::App* scenes);
  void AddSurfaces(CLI::App* app, double& min_area_m2, float& texels_per_metre,
                   CLI::Option* only_with = nullptr);
  void AddThreads(CLI::App* app, EngineChoice& engine);
  void AddSceneId(CLI::App* app, std::string& scene_id, const char* help);
  absl::Status CheckCommandNames(const std::vector<std::string>& arguments) const;

  // An option of one text, read by `read`; the second may be given several times.
  using Read = std::function<absl::Status(const std::string&)>;
  CLI::Option* Add(CLI::App* app, const char* name, const std::string& form, const char* help,
                   Read read);
  CLI::Option* AddRepeated(CLI::App* app, const char* name, const std::string& form,
                           const char* help, Read read);
  template <typename Target, typename T>
  void AddTo(CLI::App* app, const char* name, const char* form, const char* help, Target& target,
             absl::StatusOr<T> (*read)(std::string_view option, std::string_view text)) {
    Add(app, name, form, help, [&target, name, read](const std::string& text) {
      auto value = read(name, text);
      if (value.ok()) target = *std::move(value);
      return value.status();
    });
  }

  CLI::App app_{"Shadows as a service: bakes, streams and draws soft shadows.", "penumbra"};
  absl::Status error_;
  BakeCommand bake_;
  ViewCommand view_;
  PushCommand push_;
  WatchCommand watch_;
  TechniquesCommand techniques_;
  InfoCommand info_;
  TopCommand top_;
  DemoCommand demo_;
  ReceiversCommand receivers_;
  ScenesListCommand scenes_list_;
  ScenesExportCommand scenes_export_;
  ScenesImportCommand scenes_import_;
  ScenesDeleteCommand scenes_delete_;
  ScenesDiffCommand scenes_diff_;
  ReplayCommand replay_;
  WhoCommand who_;
  EditCommand edit_;
  EditControlCommand edit_control_;
  Command chosen_;
};

template <typename C>
CLI::App* Grammar::AddCommand(C& command, const char* name, const char* summary, CLI::App* parent) {
  CLI::App* app = (parent ? parent : &app_)->add_subcommand(name, summary);
  app->final_callback([this, &command] { chosen_ = command; });
  return app;
}

}  // namespace penumbra
