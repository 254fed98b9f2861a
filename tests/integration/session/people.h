// People in a scene, each with an engine of their own, and what they hear of one another.
#pragma once

#include <gtest/gtest.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "client/session/remote_engine.h"
#include "client/session/scene_presence.h"
#include "tests/integration/session/remote_engine_fixture.h"

namespace penumbra::testing {

// Keeps every change; waits until those who are here are as they should be.
class Gallery {
 public:
  PresenceCallback callback() {
    return [this](const PresenceChange& change) {
      std::lock_guard lock(mutex_);
      changes_.push_back(change);
      came_.notify_all();
    };
  }
  template <typename Predicate>
  bool WaitUntil(Predicate is_so) {
    std::unique_lock lock(mutex_);
    return came_.wait_for(lock, kPatience,
                          [&] { return !changes_.empty() && is_so(changes_.back().now); });
  }
  bool WaitForEnd() {
    std::unique_lock lock(mutex_);
    return came_.wait_for(lock, kPatience,
                          [&] { return !changes_.empty() && !changes_.back().ended.ok(); });
  }
  std::vector<PresenceChange> changes() {
    std::lock_guard lock(mutex_);
    return changes_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::vector<PresenceChange> changes_;
};

inline std::vector<std::string> NamesOf(const Attendance& attendance) {
  std::vector<std::string> names;
  for (const Participant& other : attendance.others) names.push_back(other.presence.display_name);
  return names;
}

inline auto AreHere(std::vector<std::string> names) {
  return [names](const Attendance& now) { return now.is_current && NamesOf(now) == names; };
}

struct Person {
  std::unique_ptr<RemoteEngine> engine;
  std::unique_ptr<Gallery> gallery = std::make_unique<Gallery>();
  std::unique_ptr<ScenePresence> presence{};  // ends first

  std::string id() const { return presence->attendance().own_id; }
  bool SeesThemselvesEdit() const {
    return gallery->WaitUntil([](const Attendance& now) { return now.edits_self(); });
  }
  absl::StatusOr<Revision> MoveBox(float x) const {
    return engine->Commit("studio", Studio(Vec3(x, 0.5f, 0)));
  }
};

class PeopleTest : public RemoteEngineTest {
 protected:
  void SetUp() override {
    RemoteEngineTest::SetUp();
    maker_ = Connect();
    ASSERT_EQ(maker_->CreateScene("studio"), absl::OkStatus());
    ASSERT_TRUE(maker_->Commit("studio", Studio()).ok());
  }

  Person EnterAt(const std::string& address, const std::string& name, double reconnect_for_s) {
    auto engine = RemoteEngine::Connect({.address = address, .reconnect_for_s = reconnect_for_s});
    EXPECT_TRUE(engine.ok()) << engine.status();
    Person person{.engine = *std::move(engine)};
    auto presence =
        person.engine->Enter("studio", {.display_name = name}, person.gallery->callback());
    EXPECT_TRUE(presence.ok()) << presence.status();
    if (presence.ok()) person.presence = *std::move(presence);
    return person;
  }
  Person Enter(const std::string& name) { return EnterAt(server_->address(), name, 0); }

  std::unique_ptr<RemoteEngine> maker_;
};

}  // namespace penumbra::testing
