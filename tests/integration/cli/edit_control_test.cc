// penumbra edit-control at a server that refuses what comes after editing was taken, as one does
// when whoever is to have it leaves in that moment.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>
#include <sstream>
#include <string>
#include <vector>

#include "client/cli/run_command.h"
#include "proto/convert/status_convert.h"
#include "tests/support/hostile_server.h"

namespace penumbra::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Control = v1::EditControl;

// Bob is here and edits, or nobody does. Taking is granted, silently; Bob cannot be given it.
class ScarceEditing {
 public:
  explicit ScarceEditing(std::string editor)
      : editor_(std::move(editor)),
        server_([this](HostileServer::Stream& stream, int) { return Serve(stream); }) {}

  EditControlCommand Command(EditingAction action) const {
    EditControlCommand command{.scene_id = "studio", .action = action, .who = "Bob"};
    command.engine.server = server_.address();
    command.person = {.name = "Ada", .takes_from_other = true};
    return command;
  }
  std::vector<Control> controls() {
    std::lock_guard lock(mutex_);
    return controls_;
  }

 private:
  grpc::Status Serve(HostileServer::Stream& stream) {
    v1::SessionResponse list;
    v1::PresenceUpdate& update = *list.mutable_presence_update();
    update.set_is_everything(true);
    update.set_single_editor(!editor_.empty());
    update.set_editor_id(editor_);
    update.add_participants()->set_participant_id("b");
    update.mutable_participants(0)->mutable_presence()->set_display_name("Bob");
    stream.Write(list);
    v1::SessionRequest request;
    while (stream.Read(&request)) {
      if (request.has_edit_control()) Answer(stream, request.edit_control());
    }
    return grpc::Status::OK;
  }
  void Answer(HostileServer::Stream& stream, const Control& control) {
    v1::SessionResponse response;
    v1::EditControlResult& result = *response.mutable_edit_control_result();
    result.set_request_id(control.request_id());
    std::lock_guard lock(mutex_);
    controls_.push_back(control);
    if (control.has_hand_over() && controls_.size() == 2) {
      *result.mutable_error() = ToProto(absl::NotFoundError("found that they have left"));
    }
    stream.Write(response);
  }

  const std::string editor_;
  std::mutex mutex_;
  std::vector<Control> controls_;
  HostileServer server_;
};

struct Said {
  std::ostringstream out, err;
  Console console() { return {.out = out, .err = err}; }
};

std::vector<std::string> Names(const std::vector<Control>& controls) {
  std::vector<std::string> names;
  for (const Control& control : controls) {
    names.push_back(control.has_take()        ? "take"
                    : control.has_hand_over() ? "to " + control.hand_over().participant_id()
                    : control.release().keep_single_editor() ? "to whoever takes it"
                                                             : "to everybody");
  }
  return names;
}

TEST(EditControlTest, WhoeverCannotHandOverLeavesItAsItWas) {
  Said said;
  ScarceEditing everybody_edits("");
  const absl::Status status = penumbra::Run(everybody_edits.Command(EditingAction::kHandOver),
                                            said.console(), std::stop_token());
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound) << status;
  EXPECT_THAT(Names(everybody_edits.controls()), ElementsAre("take", "to b", "to everybody"));

  ScarceEditing bob_edits("b");
  EXPECT_FALSE(
      penumbra::Run(bob_edits.Command(EditingAction::kHandOver), said.console(), std::stop_token())
          .ok());
  EXPECT_THAT(Names(bob_edits.controls()), ElementsAre("take", "to b", "to b"));
  EXPECT_EQ(said.out.str(), "");
}

TEST(EditControlTest, NobodyIsAccusedWhereNothingIsHeard) {
  Said said;
  ScarceEditing silent("");
  const absl::Status status =
      penumbra::Run(silent.Command(EditingAction::kTake), said.console(), std::stop_token());
  EXPECT_EQ(status.code(), absl::StatusCode::kDeadlineExceeded) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("no word within 5 s"));
  EXPECT_EQ(said.out.str(), "");
}

}  // namespace
}  // namespace penumbra::testing
