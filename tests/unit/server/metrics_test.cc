// The metrics as Prometheus reads them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "render/scene/field_error.h"
#include "server/log/refusal.h"
#include "server/metrics/job_notes.h"
#include "server/metrics/metrics_collector.h"
#include "server/metrics/metrics_endpoint.h"
#include "tests/support/http_get.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

class MetricsTest : public ::testing::Test {
 protected:
  std::string Scrape() {
    if (!endpoint_) {
      auto endpoint = MetricsEndpoint::Open(
          "127.0.0.1:0", std::make_shared<MetricsCollector>(counters_, [this] { return gauges_; }));
      EXPECT_TRUE(endpoint.ok()) << endpoint.status();
      endpoint_ = *std::move(endpoint);
    }
    return HttpGet(endpoint_->address(), "/metrics");
  }

  ServerCounters counters_;
  MetricsGauges gauges_;
  std::unique_ptr<MetricsEndpoint> endpoint_;
};

TEST_F(MetricsTest, CountersAndGaugesAreWhatTheyAreAtTheScrape) {
  counters_.commits = 3;
  gauges_.blob_bytes = uint64_t{5} << 32;
  gauges_.gl_vendor = "Mesa \"x\"\nforged 1";
  const std::string first = Scrape();
  EXPECT_EQ(SampleIn(first, "penumbra_commits_total"), 3);
  EXPECT_EQ(SampleIn(first, "penumbra_blob_bytes"), 5.0 * (1ull << 32));
  EXPECT_EQ(SampleIn(first, "forged"), -1) << "labels are escaped";
  EXPECT_THAT(first, HasSubstr("vendor=\"Mesa \\\"x\\\"\\nforged 1\""));
  ++counters_.commits;
  counters_.cache_hits = 2;
  gauges_.results.found_in_store = 7;
  const std::string second = Scrape();
  EXPECT_EQ(SampleIn(second, "penumbra_commits_total"), 4);
  EXPECT_EQ(SampleIn(second, "penumbra_artifact_cache_lookups_total{result=\"hit\"}"), 2);
  EXPECT_EQ(SampleIn(second, "penumbra_result_lookups_total{found=\"disk\"}"), 7);
}

TEST_F(MetricsTest, CallsAreCountedByMethodAndCodeAndTimed) {
  counters_.ObserveCall("CreateScene", "OK", 0.002);
  counters_.ObserveCall("CreateScene", "NOT_FOUND", 0.2);
  counters_.ObserveCall("CreateScene", "OK", 0.002);
  const std::string text = Scrape();
  EXPECT_EQ(SampleIn(text, "penumbra_calls_total{code=\"OK\",method=\"CreateScene\"}"), 2);
  EXPECT_EQ(SampleIn(text, "penumbra_call_seconds_count{method=\"CreateScene\"}"), 3);
  EXPECT_EQ(SampleIn(text, "penumbra_call_seconds_bucket{method=\"CreateScene\",le=\"0.0025\"}"),
            2);
}

TEST_F(MetricsTest, JobsAreTimedAndTheirFailuresCountedByReason) {
  const JobObserver note = NoteJobs(counters_, QuietLogger());
  note({.technique = "soft_texture",
        .waited_ms = 2,
        .computed_ms = 30,
        .first_artifact_ms = 12,
        .final_artifact_ms = 32});
  note({.technique = "shadow_width",
        .outcome = JobReport::Outcome::kFailed,
        .status = FieldError(absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY", "x", "y")});
  note({.technique = "shadow_width",
        .outcome = JobReport::Outcome::kFailed,
        .status = absl::InternalError("no reason given")});
  const std::string text = Scrape();
  EXPECT_EQ(SampleIn(text, "penumbra_job_queue_seconds_count"), 3);
  EXPECT_EQ(SampleIn(text, "penumbra_job_queue_seconds_sum"), 0.002);
  EXPECT_EQ(SampleIn(text, "penumbra_job_compute_seconds_sum{technique=\"soft_texture\"}"), 0.03);
  EXPECT_EQ(SampleIn(text, "penumbra_first_artifact_seconds_sum"), 0.012);
  EXPECT_EQ(SampleIn(text, "penumbra_final_artifact_seconds_count"), 1);
  EXPECT_EQ(SampleIn(text, "penumbra_failures_total{reason=\"OUT_OF_MEMORY\"}"), 1);
  EXPECT_EQ(SampleIn(text, "penumbra_failures_total{reason=\"INTERNAL\"}"), 1);
}

TEST_F(MetricsTest, EveryFamilyHasHelpATypeAndAUnitOfPrometheus) {
  counters_.ObserveCall("CreateScene", "OK", 0.002);
  counters_.CountFailure("STALE_BASE");
  const std::string text = Scrape();
  std::set<std::string> helped, typed;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_match(line, match, std::regex("# HELP (penumbra_\\w+) .+"))) {
      EXPECT_TRUE(helped.insert(match[1]).second) << line << ": twice";
    } else if (std::regex_match(line, match, std::regex("# TYPE (penumbra_\\w+) (\\w+)"))) {
      typed.insert(match[1]);
      EXPECT_EQ(match[2] == "counter", std::string(match[1]).ends_with("_total")) << line;
    }
  }
  EXPECT_EQ(helped, typed);
  EXPECT_GE(helped.size(), 30u);
}

TEST(MetricsEndpointTest, ListensOnLoopbackAlone) {
  const ServerCounters counters;
  const auto collector =
      std::make_shared<MetricsCollector>(counters, [] { return MetricsGauges{}; });
  for (const char* address : {"0.0.0.0:0", "example.org:9464", "127.0.0.1", "unix:/tmp/metrics",
                              "127.0.0.1:99999", "[::1]:0", "9464", ""}) {
    const auto endpoint = MetricsEndpoint::Open(address, collector);
    EXPECT_EQ(ErrorReason(endpoint.status()), "BAD_ADDRESS") << address;
    EXPECT_EQ(ErrorFieldPath(endpoint.status()), "metrics_listen");
  }
  for (const char* address : {"127.0.0.1:0", "127.0.0.2:0", "localhost:0"}) {
    const auto endpoint = MetricsEndpoint::Open(address, collector);
    ASSERT_TRUE(endpoint.ok()) << endpoint.status();
    EXPECT_FALSE((*endpoint)->address().ends_with(":0"));
  }
}

TEST(MetricsEndpointTest, AnAddressInUseIsAnError) {
  const ServerCounters counters;
  const auto collector =
      std::make_shared<MetricsCollector>(counters, [] { return MetricsGauges{}; });
  const auto first = MetricsEndpoint::Open("127.0.0.1:0", collector);
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = MetricsEndpoint::Open((*first)->address(), collector);
  EXPECT_EQ(ErrorReason(second.status()), "CANNOT_LISTEN");
  EXPECT_THAT(std::string(second.status().message()), HasSubstr((*first)->address()));
}

}  // namespace
}  // namespace penumbra::testing
