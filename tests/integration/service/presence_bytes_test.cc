// What a client can put into its presence beside what there is, and what others get of it.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/integration/service/raw_session.h"
#include "tests/integration/service/studio.h"

namespace penumbra::testing {
namespace {

constexpr size_t kFiller = 950'000;
constexpr int kLaterField = 15;  // which nobody knows

std::string Hello(const std::string& presence) {
  return HelloBytes() + Field(v1::SessionRequest::kHelloFieldNumber,
                              Field(v1::Hello::kPresenceFieldNumber, presence));
}

std::string PresenceOf(const std::string& name) {
  return Field(v1::Presence::kDisplayNameFieldNumber, name) +
         Field(kLaterField, std::string(kFiller, 'x'));
}

// All of them in one update would be more than a client takes.
TEST_F(StudioTest, B15WhatNobodyKnowsOfAPresenceIsNotToldToOthers) {
  std::vector<std::unique_ptr<RawSession>> others;
  for (int i = 0; i < 5; ++i) {
    others.push_back(std::make_unique<RawSession>(*client_));
    const auto welcome = others.back()->Ask(Hello(PresenceOf("guest")));
    ASSERT_FALSE(welcome.welcome().participant_id().empty());
  }
  WireSession watcher(client_->stub());
  v1::SessionRequest hello;
  hello.mutable_hello()->set_scene_id("studio");
  hello.mutable_hello()->add_protocol_versions(1);
  hello.mutable_hello()->mutable_presence()->set_display_name("watcher");
  watcher.Send(hello);
  const auto all = watcher.ReadUntil(v1::SessionResponse::kPresenceUpdate);
  ASSERT_TRUE(all) << watcher.End();
  EXPECT_EQ(all->presence_update().participants_size(), 5);
  EXPECT_LT(all->ByteSizeLong(), 1'000u);

  others[0]->Send(Field(v1::SessionRequest::kPresenceFieldNumber, PresenceOf("renamed")));
  const auto renamed = watcher.ReadUntil(v1::SessionResponse::kPresenceUpdate);
  ASSERT_TRUE(renamed) << watcher.End();
  ASSERT_EQ(renamed->presence_update().participants_size(), 1);
  EXPECT_EQ(renamed->presence_update().participants(0).presence().display_name(), "renamed");
  EXPECT_LT(renamed->ByteSizeLong(), 200u);
}

}  // namespace
}  // namespace penumbra::testing
