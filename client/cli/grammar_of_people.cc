// Commands whose user others see, and the options that say who that is.
#include <map>
#include <string>

#include "client/cli/edit_script.h"
#include "client/cli/grammar.h"
#include "client/cli/option_values.h"

namespace penumbra {

void Grammar::AddPerson(CLI::App* app, PersonChoice& person) {
  app->add_option("--name", person.name,
                  "What the others in the scene see you as (default: your login name)")
      ->type_name("TEXT");
  AddTo(app, "--colour", "RRGGBB", "And in which colour (default: one of the name's own)",
        person.colour_rgb, ReadColour);
}

void Grammar::AddEditing(CLI::App* app, PersonChoice& person) {
  app->add_flag("--take", person.takes_editing,
                "Be the only one who edits meanwhile, if nobody else is");
  app->add_flag("--from-other", person.takes_from_other, "Even if somebody else is");
}

void Grammar::AddPeople() {
  CLI::App* who = AddCommand(who_, "who", "Say who else is in a server's scene");
  AddEngine(who, who_.engine, true);
  AddSceneId(who, who_.scene_id, "The server's scene");
  AddPerson(who, who_.person);
  CLI::Option* watch =
      who->add_flag("--watch", who_.watch, "Again whenever that changes, until interrupted");
  Add(who, "--seconds", "S", "Stop watching after a time", [this](const std::string& text) {
    return SetSeconds(text, who_.max_seconds);
  })->needs(watch);
  who->add_flag("--json", who_.json, "One JSON object a line");

  CLI::App* edit = AddCommand(edit_, "edit", "Edit a server's scene, line by line");
  AddEngine(edit, edit_.engine, true);
  AddSceneId(edit, edit_.scene_id, "The server's scene");
  AddPerson(edit, edit_.person);
  AddEditing(edit, edit_.person);
  CLI::Option* lines =
      edit->add_option("LINE", edit_.lines, "What to do, each in quotes")->type_name("\"WORDS\"");
  edit->add_option("--script", edit_.script,
                   "A file of such lines; - is standard input (default where no LINE is given)")
      ->type_name("FILE")
      ->excludes(lines);
  edit->add_flag("--keep-going", edit_.keeps_going,
                 "Go on after a line that failed, as is done where somebody types");
  edit->footer(EditScript::Help());
}

void Grammar::AddEditControl() {
  CLI::App* app = AddCommand(edit_control_, "edit-control", "Say who may edit a server's scene");
  AddEngine(app, edit_control_.engine, true);
  AddSceneId(app, edit_control_.scene_id, "The server's scene");
  AddPerson(app, edit_control_.person);
  app->add_flag("--from-other", edit_control_.person.takes_from_other,
                "Even if somebody else edits");
  Add(app, "--seconds", "S", "Of take: how long (default: until interrupted)",
      [this](const std::string& text) { return SetSeconds(text, edit_control_.max_seconds); });
  app->add_flag("--json", edit_control_.json, "Print who edits as JSON");
  app->require_subcommand(1);
  const auto add_action = [&](CLI::App* parent, const char* name, const char* help,
                              EditingAction action) {
    CLI::App* added = parent->add_subcommand(name, help);
    added->final_callback([this, action] { edit_control_.action = action; });
    added->fallthrough();
    return added;
  };
  add_action(app, "take", "Be the only one who edits, until interrupted", EditingAction::kTake);
  add_action(app, "hand-over", "Let somebody be the only one who edits", EditingAction::kHandOver)
      ->add_option("WHO", edit_control_.who, "Their name, or their id as `who --json` tells it")
      ->required();
  CLI::App* one = app->add_subcommand("one-editor", "Let only one edit at a time, or everybody");
  one->require_subcommand(1);
  one->fallthrough();
  add_action(one, "on", "Nobody edits until somebody takes it", EditingAction::kOneEditorOn);
  add_action(one, "off", "Everybody may edit", EditingAction::kOneEditorOff);
}

}  // namespace penumbra
