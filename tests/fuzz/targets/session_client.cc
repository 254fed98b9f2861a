// What a client says, and what that does at once. What it hears is in session_client_hears.cc.

#include "tests/fuzz/targets/session_client.h"

#include <algorithm>
#include <span>
#include <utility>

#include "grpcpp/support/byte_buffer.h"
#include "grpcpp/support/slice.h"
#include "proto/convert/geometry_convert.h"
#include "server/session/bounded_parse.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/targets/scene_rules.h"
#include "tests/fuzz/targets/session_request_rules.h"

namespace penumbra::fuzzing {
namespace {

v1::SessionResponse Parsed(const grpc::ByteBuffer& bytes) {
  grpc::Slice slice;
  v1::SessionResponse response;
  Require(bytes.DumpToSingleSlice(&slice).ok() &&
              response.ParseFromArray(slice.begin(), static_cast<int>(slice.size())),
          "what is sent can be read");
  return response;
}

}  // namespace

SessionClient::SessionClient(SessionServer& server, SceneHistory& history, CountAnswer count)
    : server_(server), history_(history), count_(std::move(count)), session_(server.Open()) {}

void SessionClient::Say(const std::string& bytes) {
  if (!session_->has_room()) Read();
  Require(session_->has_room() != is_over_, "whoever has read all is heard, until the end");
  Said said;
  const std::span<const uint8_t> data(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  said.parsed = ParseBounded(data, server_.limits(), said.request);
  const auto before = server_.Newest();
  if (said.parsed.ok()) {
    RequireBounded(bytes, server_.limits(), said.request);
    RequireMeaning(said.request, *before);
  }
  const std::string editor = server_.Editor();
  const grpc::Slice slice(bytes);
  session_->OnRequest(grpc::ByteBuffer(&slice, 1));
  NoteScene(*before, server_.Newest(), said);
  NoteEditor(editor, said);
  if (!is_over_) said_.push_back(std::move(said));
}

void SessionClient::NoteScene(const Scene& before, const std::shared_ptr<const Scene>& after,
                              Said& said) {
  said.revision = after->revision();
  said.has_grown = after->revision() != before.revision();
  if (!said.has_grown) return Require(after.get() == &before, "a scene stays as it is");
  Require(!is_over_ && said.parsed.ok() && said.request.has_commit() &&
              after->revision() == before.revision() + 1,
          "a commit in an open session alone changes a scene, by one revision");
  RequireRules(*after, server_.limits().scene);
  history_.hashes.push_back(after->content_hash());
  const std::string& key = said.request.commit().idempotency_key();
  Require(key.empty() || history_.answers.emplace(key, after->revision()).second,
          "a key is applied once");
  server_.TellOfCommit(*after);
}

void SessionClient::NoteEditor(const std::string& before, Said& said) const {
  said.has_other_editor = server_.Editor() != before;
  if (!said.has_other_editor) return;
  const bool is_mine = !before.empty() && before == participant_id_;
  Require(!is_over_ && said.parsed.ok() && said.request.has_edit_control() &&
              (is_mine || said.request.edit_control().has_take()),
          "nobody gives away another's");
}

void SessionClient::Read() {
  // As the room does within 50 ms.
  session_->OnPresenceChanged();
  size_t answers = 0;
  for (;;) {
    const Session::Output output = session_->Next();
    Require(!output.message || !is_over_, "an ended session sends nothing more");
    Require(!is_over_ || output.end, "and stays ended");
    if (output.end && !is_over_) OnEnd(*output.end);
    if (!output.message) break;
    Require(output.message->Length() <= server_.limits().max_message_bytes,
            "what is sent fits into a message");
    session_->OnSent();
    answers += Hear(Parsed(*output.message)) ? 1 : 0;
  }
  Settle();
  Require(said_.empty(), "all that was said is answered");
  Require(answers <= server_.limits().max_queued_replies, "few answers wait to be read");
}

void SessionClient::ReadOfDeletion() {
  is_scene_gone_ = true;
  Read();
  Require(is_over_ || !is_welcome_, "a session ends with its scene");
  Require(is_over_ || followed_.empty(), "whoever was not welcomed follows nothing");
}

void SessionClient::Leave() {
  session_->Close();
  const Session::Output output = session_->Next();
  Require(!output.message && !output.end && !session_->has_room(), "a closed session is silent");
}

// Where a request is right and nothing is to be said of it. With all before it done.
bool SessionClient::NeedsNoAnswer(const Said& said) const {
  if (!said.parsed.ok() || !is_welcome_) return false;
  const v1::SessionRequest& request = said.request;
  switch (request.request_case()) {
    case v1::SessionRequest::kCredit:
      return followed_.contains(request.credit().subscription_id());
    case v1::SessionRequest::kAcknowledgement:
      return followed_.contains(request.acknowledgement().subscription_id());
    case v1::SessionRequest::kViewReport:
      return !request.view_report().has_camera() || FromProto(request.view_report().camera()).ok();
    case v1::SessionRequest::kPresence:
      return has_presence_ && CheckPresence(request.presence(), server_.limits()).ok();
    default:
      return false;
  }
}

void SessionClient::Settle() {
  while (!said_.empty() && NeedsNoAnswer(said_.front())) {
    const v1::SessionRequest& request = said_.front().request;
    if (request.has_credit()) {
      uint64_t& credit = followed_.at(request.credit().subscription_id()).credit;
      credit = std::min<uint64_t>(credit + request.credit().updates(), server_.limits().max_credit);
    }
    count_(true);
    said_.pop_front();
  }
}

SessionClient::Said SessionClient::TakeAnswered() {
  Settle();
  Require(!said_.empty(), "nothing is answered that was not said");
  Said said = std::move(said_.front());
  said_.pop_front();
  return said;
}

}  // namespace penumbra::fuzzing
