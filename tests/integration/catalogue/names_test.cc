// Rows B01 to B03 and E06: ids and names.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "proto/convert/scene_convert.h"
#include "tests/integration/catalogue/catalogue_test.h"

namespace penumbra::testing {
namespace {

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

using NameRowsTest = CatalogueTest;

// What looks like an id, or is text, and is none.
std::vector<std::string> TextsThatAreNoIds() {
  return {"",
          " ",
          "a b",
          "../up",
          "a/b",
          "/etc/passwd",
          "a\\b",
          std::string("a\0b", 3),
          "two\r\nlines",
          "\x1b[31mred",
          "%2e%2e",
          "a:b",
          "~1",
          "\xe2\x80\xae"
          "oiduts",  // right to left
          "stu\xe2\x80\x8b"
          "dio",            // a space of no width
          "\xd1\x95tudio",  // a letter of another alphabet
          "caf\xc3\xa9",
          std::string(129, 'x'),
          std::string(1'000'000, 'x')};
}

std::vector<std::string> BytesThatAreNoText() {
  return {"\xff\xfe", "\xc0\x80", "\xed\xa0\x80", "a\x80", std::string(1'000, '\xf4')};
}

TEST_F(NameRowsTest, B01ScenesAreNotNamedByWhatIsNoId) {
  for (const std::string& id : TextsThatAreNoIds()) {
    const Refusal refusal{kInvalid, "BAD_ID", "scene_id"};
    ExpectRefused([&] { return client_->CreateScene(id); }, refusal);
    ExpectRefused([&] { return client_->DeleteScene(id); }, refusal);
    WireSession session(client_->stub());
    v1::SessionRequest hello;
    hello.mutable_hello()->add_protocol_versions(1);
    hello.mutable_hello()->set_scene_id(id);
    session.Send(hello);
    ExpectRefused([&] { return session.End(); }, {kInvalid, "BAD_ID", "hello.scene_id"});
  }
  for (const std::string& bytes : BytesThatAreNoText()) {
    ExpectRefused([&] { return client_->CreateScene(bytes); }, {kInvalid, "MALFORMED", "request"});
  }
  EXPECT_EQ(client_->ListScenes()->size(), 1u);
}

TEST_F(NameRowsTest, B01ObjectsAreNotNamedByWhatIsNoId) {
  for (const std::string& id : TextsThatAreNoIds()) {
    SceneDelta delta;
    delta.upsert_instances = {Box({1, 1, 1}, id)};
    ExpectRefused(ToProto(delta), {kInvalid, "BAD_ID", "upsert_instances[0].id"});
    delta = {};
    delta.upsert_lights = {SquareLight()};
    delta.upsert_lights[0].id = id;
    ExpectRefused(ToProto(delta), {kInvalid, "BAD_ID", "upsert_lights[0].id"});
    delta = {};
    delta.upsert_receivers = {FloorReceiver(id, 1, 8)};
    ExpectRefused(ToProto(delta), {kInvalid, "BAD_ID", "upsert_receivers[0].id"});
    ArtifactSpec spec = FloorSpec();
    spec.light_id = id;
    ExpectRefused([&] { return session_->Subscribe(2, spec, 1); },
                  {kInvalid, "BAD_ID", "spec.light_id"});
  }
}

// What nothing can be called is not there. The answer quotes it, and is no longer for that.
TEST_F(NameRowsTest, B01RemovalsOfWhatIsNoIdFindNothing) {
  for (const std::string& id : TextsThatAreNoIds()) {
    v1::SceneDelta delta;
    delta.add_remove_instances(id);
    ExpectRefused(delta, {absl::StatusCode::kNotFound, "UNKNOWN_ID", "remove_instances[0]"});
  }
}

TEST_F(NameRowsTest, B01KeysAreIdsToo) {
  for (const std::string& key : {std::string("a b"), std::string("../k"), std::string(65, 'k')}) {
    ExpectRefused(
        [&] {
          return FromProto(session_->Commit(MoveBox({1, 1, 1}), key).error());
        },
        {kInvalid, "BAD_ID", "idempotency_key"});
  }
}

TEST_F(NameRowsTest, B02NamesOfPeopleAreNoKeys) {
  // One name in both of its forms, and once more.
  const std::string composed = "Zo\xc3\xab", decomposed = "Zoe\xcc\x88";
  std::vector<std::unique_ptr<WireSession>> people;
  std::set<std::string> ids;
  for (const std::string& name : {composed, decomposed, composed}) {
    people.push_back(std::make_unique<WireSession>(client_->stub()));
    v1::SessionRequest hello;
    hello.mutable_hello()->add_protocol_versions(1);
    hello.mutable_hello()->set_scene_id("studio");
    hello.mutable_hello()->mutable_presence()->set_display_name(name);
    people.back()->Send(hello);
    ids.insert(people.back()->ReadUntil(v1::SessionResponse::kWelcome)->welcome().participant_id());
  }
  EXPECT_EQ(ids.size(), 3u);
  const auto news = people[2]->ReadUntil(v1::SessionResponse::kPresenceUpdate)->presence_update();
  std::vector<std::string> names;
  for (const auto& other : news.participants()) names.push_back(other.presence().display_name());
  EXPECT_THAT(names, ::testing::UnorderedElementsAre(composed, decomposed)) << "as they came";
}

TEST_F(NameRowsTest, B03AnIdIsTakenOnce) {
  const Refusal taken{absl::StatusCode::kAlreadyExists, "DUPLICATE_ID", "scene_id"};
  ExpectRefused([&] { return client_->CreateScene("studio"); }, taken);
  // Of many who ask at the same time one gets it.
  std::atomic<int> made = 0, refused = 0;
  std::vector<std::thread> askers;
  for (int i = 0; i < 8; ++i) {
    askers.emplace_back([&] {
      const absl::Status status = WireClient(server_->address()).CreateScene("wanted");
      made += status.ok();
      refused += absl::IsAlreadyExists(status) && ErrorReason(status) == "DUPLICATE_ID";
    });
  }
  for (std::thread& asker : askers) asker.join();
  EXPECT_EQ(made, 1);
  EXPECT_EQ(refused, 7);
  ASSERT_EQ(session_->Subscribe(7, FloorSpec(), 1), absl::OkStatus());
  ExpectRefused([&] { return session_->Subscribe(7, FloorSpec(8), 1); },
                {absl::StatusCode::kAlreadyExists, "DUPLICATE_ID", "subscription_id"});
}

// Of what the server names itself each bit is seen both ways, and nothing twice.
TEST_F(NameRowsTest, E06WhatTheServerNamesHas128RandomBits) {
  std::set<std::string> seen;
  std::array<int, 128> ones{};
  constexpr int kDraws = 64;
  for (int draw = 0; draw < kDraws; ++draw) {
    ASSERT_EQ(client_->CreateScene("drawn"), absl::OkStatus());
    const auto welcome = WireSession(client_->stub()).Hello("drawn");
    ASSERT_EQ(welcome.incarnation().size(), 16u);
    EXPECT_TRUE(seen.insert(welcome.incarnation()).second);
    for (size_t bit = 0; bit < ones.size(); ++bit) {
      ones[bit] += welcome.incarnation()[bit / 8] >> (bit % 8) & 1;
    }
    ASSERT_EQ(client_->DeleteScene("drawn"), absl::OkStatus());
  }
  for (const int count : ones) EXPECT_TRUE(count > 0 && count < kDraws) << count;
}

}  // namespace
}  // namespace penumbra::testing
