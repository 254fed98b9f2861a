#include "server/session/subscription_feed.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "penumbra/v1/session.pb.h"
#include "proto/convert/artifact_assembler.h"

namespace penumbra {
namespace {

constexpr uint32_t kSide = 256;
constexpr uint64_t kId = 9;

// An engine whose artifacts the test makes up.
class ScriptedEngine : public SharedEngine {
 public:
  absl::StatusOr<std::unique_ptr<SharedSubscription>> SubscribeFor(
      const Party& party, const std::string&, const ArtifactSpec&,
      ArtifactCallback callback) override {
    publish = std::move(callback);
    ++subscriptions;
    auto subscription = std::make_unique<ScriptedSubscription>(*this);
    subscription->Join(party);
    return subscription;
  }

  ArtifactCallback publish;
  int subscriptions = 0;
  std::multiset<Party> parties;

 private:
  class ScriptedSubscription : public SharedSubscription {
   public:
    explicit ScriptedSubscription(ScriptedEngine& engine) : engine_(engine) {}
    void Join(const Party& party) override { engine_.parties.insert(party); }
    void Leave(const Party& party) override { engine_.parties.erase(engine_.parties.find(party)); }

   private:
    ScriptedEngine& engine_;
  };
};

const Party kMe{"me", "1"};
const Party kYou{"you", "2"};

std::shared_ptr<const Artifact> MakeArtifact(Revision revision, bool radiance = false) {
  SoftShadowTexture texture;
  texture.light = {"lamp", PointLight{}};
  texture.receiver.width = texture.receiver.height = kSide;
  texture.visibility = {.width = kSide,
                        .height = kSide,
                        .sample_count = 16,
                        .counts = std::vector<uint16_t>(kSide * kSide, 16)};
  // One texel that moves with the revision: in the first tile, or in the last.
  texture.visibility.counts[revision % 2 == 0 ? 0 : kSide * kSide - 1] = 3;
  if (radiance) {
    std::vector<Vec3> texels(kSide * kSide);
    uint32_t noise = 1;
    for (Vec3& texel : texels) {
      for (int k = 0; k < 3; ++k) {
        noise = noise * 1664525u + 1013904223u;
        texel[k] = static_cast<float>(noise);
      }
    }
    texture.radiance = RadianceTexture{.width = kSide, .height = kSide, .texels = texels};
  }
  auto artifact = std::make_shared<Artifact>();
  artifact->header.revision = revision;
  artifact->header.is_final = true;
  artifact->header.light_samples.resize(16);
  artifact->payload = std::move(texture);
  return artifact;
}

class SubscriptionFeedTest : public ::testing::Test {
 protected:
  SubscriptionFeed MakeFeed(uint32_t credit) {
    return SubscriptionFeed(kId, streams_.Follow(kMe, "s", "1", {}).value(), credit, limits_);
  }
  void Publish(Revision revision, bool radiance = false) {
    engine_.publish({revision, absl::OkStatus(), MakeArtifact(revision, radiance)});
  }
  v1::ArtifactUpdate Next(SubscriptionFeed& feed) {
    EXPECT_TRUE(feed.HasMessage());
    auto message = feed.NextMessage();
    EXPECT_LE(message.bytes.Length(), limits_.max_message_bytes);
    grpc::Slice slice;
    EXPECT_TRUE(message.bytes.DumpToSingleSlice(&slice).ok());
    v1::SessionResponse response;
    EXPECT_TRUE(response.ParseFromArray(slice.begin(), static_cast<int>(slice.size())));
    EXPECT_EQ(response.artifact_update().subscription_id(), kId);
    EXPECT_EQ(response.artifact_update().end_of_update(), message.ends_update);
    return response.artifact_update();
  }

  ServerLimits limits_;
  ServerCounters counters_;
  ScriptedEngine engine_;
  StreamServices services_{counters_};
  StreamTable streams_{engine_, services_};
};

// An engine that is busy with one scene.
class BusyEngine : public ScriptedEngine {
 public:
  absl::StatusOr<std::unique_ptr<SharedSubscription>> SubscribeFor(
      const Party& party, const std::string& scene_id, const ArtifactSpec& spec,
      ArtifactCallback callback) override {
    if (scene_id == "busy") {
      is_waiting.set_value();
      go_on.get_future().wait();
    }
    return ScriptedEngine::SubscribeFor(party, scene_id, spec, std::move(callback));
  }

  std::promise<void> is_waiting, go_on;
};

TEST_F(SubscriptionFeedTest, ASceneThatIsBusyKeepsNoOtherWaiting) {
  BusyEngine engine;
  StreamTable streams(engine, services_);
  auto busy = std::async(std::launch::async, [&] { return streams.Follow(kMe, "busy", "1", {}); });
  engine.is_waiting.get_future().wait();
  auto other =
      std::async(std::launch::async, [&] { return streams.Follow(kMe, "other", "2", {}); });
  EXPECT_EQ(other.wait_for(std::chrono::seconds(10)), std::future_status::ready);
  auto again = std::async(std::launch::async, [&] { return streams.Follow(kMe, "busy", "1", {}); });
  engine.go_on.set_value();
  const auto first = busy.get();
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(*again.get(), *first) << "one stream, started once";
  EXPECT_EQ(engine.subscriptions, 2);
  EXPECT_TRUE(other.get().ok());
}

TEST_F(SubscriptionFeedTest, WhoFollowsTakesPartInItsJobsUntilTheyLeave) {
  auto mine = streams_.Follow(kMe, "s", "1", {}).value();
  auto again = streams_.Follow(kMe, "s", "1", {}).value();
  auto yours = streams_.Follow(kYou, "s", "1", {}).value();
  EXPECT_EQ(mine, yours) << "one stream";
  EXPECT_EQ(engine_.parties, (std::multiset<Party>{kMe, kMe, kYou}));
  mine.reset();
  EXPECT_EQ(engine_.parties, (std::multiset<Party>{kMe, kYou}));
  auto copy = yours;
  yours.reset();
  again.reset();
  EXPECT_EQ(engine_.parties, (std::multiset<Party>{kYou}));
  copy.reset();
  EXPECT_TRUE(engine_.parties.empty());
}

TEST_F(SubscriptionFeedTest, SendsNothingBeforeThereIsAnythingOrWithoutCredit) {
  SubscriptionFeed feed = MakeFeed(0);
  EXPECT_FALSE(feed.HasMessage());
  Publish(1);
  EXPECT_FALSE(feed.HasMessage());
  feed.AddCredit(1);
  EXPECT_EQ(Next(feed).revision(), 1u);
  Publish(2);
  EXPECT_FALSE(feed.HasMessage()) << "the credit is spent";
}

TEST_F(SubscriptionFeedTest, SkipsToTheNewest) {
  SubscriptionFeed feed = MakeFeed(5);
  for (Revision revision = 1; revision <= 10; ++revision) Publish(revision);
  EXPECT_EQ(Next(feed).revision(), 10u);
  EXPECT_FALSE(feed.HasMessage());
}

TEST_F(SubscriptionFeedTest, LeavesOutWhatIsAcknowledged) {
  SubscriptionFeed feed = MakeFeed(10);
  Publish(1);
  const auto first = Next(feed);
  EXPECT_EQ(first.tiles_size(), 16);
  EXPECT_EQ(first.base_sequence(), 0u);
  EXPECT_TRUE(first.has_light_samples());
  Publish(2);
  EXPECT_EQ(Next(feed).tiles_size(), 16) << "nothing is acknowledged yet";
  feed.Acknowledge(first.update_sequence());
  Publish(3);
  const auto third = Next(feed);
  EXPECT_EQ(third.base_sequence(), first.update_sequence());
  EXPECT_EQ(third.tiles_size(), 2) << "first and last tile have changed since the first update";
  EXPECT_FALSE(third.has_light_samples());
  feed.Acknowledge(third.update_sequence() + 1000);  // never sent
  Publish(4);
  EXPECT_EQ(Next(feed).base_sequence(), first.update_sequence());
}

TEST_F(SubscriptionFeedTest, WhatIsSkippedIsNotTakenForHeld) {
  SubscriptionFeed feed = MakeFeed(1);
  Publish(1);
  feed.Acknowledge(Next(feed).update_sequence());
  Publish(2);  // skipped: no credit
  engine_.publish({3, absl::NotFoundError("no light"), nullptr});
  feed.AddCredit(2);
  const auto error = Next(feed);
  EXPECT_TRUE(error.has_error());
  EXPECT_EQ(error.update_sequence(), 1u) << "the client still holds the first artifact";
  feed.Acknowledge(error.update_sequence());
  engine_.publish({4, absl::OkStatus(), MakeArtifact(2)});
  EXPECT_EQ(Next(feed).tiles_size(), 2) << "against the first, not the second";
}

TEST_F(SubscriptionFeedTest, ANewerRevisionOfTheSameArtifactIsSmall) {
  SubscriptionFeed feed = MakeFeed(2);
  const auto artifact = MakeArtifact(1);
  engine_.publish({1, absl::OkStatus(), artifact});
  Next(feed);
  engine_.publish({2, absl::OkStatus(), artifact});
  const auto news = Next(feed);
  EXPECT_EQ(news.revision(), 2u);
  EXPECT_FALSE(news.has_header());
  EXPECT_EQ(news.tiles_size(), 0);
  EXPECT_LT(news.ByteSizeLong(), 16u);
  EXPECT_EQ(counters_.artifacts_encoded, 1u);
}

TEST_F(SubscriptionFeedTest, LargeUpdatesComeInPiecesThatAddUp) {
  limits_.max_message_bytes = 120'000;  // two tiles of radiance
  SubscriptionFeed feed = MakeFeed(1);
  Publish(1, true);
  ArtifactAssembler assembler;
  std::optional<ArtifactUpdate> update;
  int messages = 0;
  while (!update) {
    const auto message = Next(feed);
    if (messages == 0) Publish(2, true);  // in between: the update under way goes on
    auto added = assembler.Add(message);
    ASSERT_TRUE(added.ok()) << added.status();
    update = *added;
    ++messages;
  }
  EXPECT_EQ(messages, 8);
  EXPECT_EQ(update->revision, 1u);
  const auto expected = MakeArtifact(1, true);
  EXPECT_EQ(std::get<SoftShadowTexture>(update->artifact->payload).radiance->texels,
            std::get<SoftShadowTexture>(expected->payload).radiance->texels);
  EXPECT_FALSE(feed.HasMessage()) << "one update, one credit";
}

TEST_F(SubscriptionFeedTest, SubscribersShareOneStreamAndItsBytes) {
  SubscriptionFeed one = MakeFeed(1);
  SubscriptionFeed other = MakeFeed(1);
  EXPECT_EQ(engine_.subscriptions, 1);
  EXPECT_EQ(&one.stream(), &other.stream());
  Publish(1);
  EXPECT_EQ(Next(one).SerializeAsString(), Next(other).SerializeAsString());
  EXPECT_EQ(counters_.artifacts_encoded, 1u);
  EXPECT_TRUE(streams_.Follow(kMe, "s", "2", {}).ok());
  EXPECT_EQ(engine_.subscriptions, 2) << "a scene made anew is another scene";
}

}  // namespace
}  // namespace penumbra
