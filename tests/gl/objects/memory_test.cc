// Row A20 of the catalogue on the GPU: sizes that are refused before GL is asked for anything.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <climits>

#include "render/gl/buffer.h"
#include "render/gl/framebuffer.h"
#include "render/gl/readback.h"
#include "tests/gl/display/software_context.h"
#include "tests/support/test_device.h"

namespace penumbra::gl {
namespace {

using ::testing::HasSubstr;

class MemoryTest : public SoftwareContextTest {
 protected:
  void UseBytes(size_t bytes) {
    context_ = Context::Create({.device = TestDevice(), .max_memory_bytes = bytes}).value();
  }

  // With as many objects and bytes as before.
  void ExpectRefused(const absl::Status& status, absl::StatusCode code, const char* fragment) {
    EXPECT_EQ(status.code(), code) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(fragment));
    EXPECT_EQ(context_->object_count(), 0);
    EXPECT_EQ(context_->memory().used(), 0u);
    EXPECT_TRUE(context_->Check("after a refusal").ok());
  }
};

TEST_F(MemoryTest, ASoftwareDeviceMayUseAGibibyte) {
  EXPECT_EQ(context_->memory().limit(), size_t{1} << 30);
  EXPECT_EQ(context_->info().max_memory_bytes, size_t{1} << 30);
}

TEST_F(MemoryTest, A20Sides) {
  const auto refusal = [&](int width, int height, Format format) {
    return Texture::Create(*context_, {.width = width, .height = height, .format = format})
        .status();
  };
  for (const int side : {0, -1, INT_MIN, 16385, INT_MAX}) {
    ExpectRefused(refusal(side, 1, Format::kR8), absl::StatusCode::kInvalidArgument,
                  "need sides of 1 to 16384");
    ExpectRefused(refusal(1, side, Format::kR8), absl::StatusCode::kInvalidArgument,
                  "need sides of 1 to 16384");
  }
  // 2³² bytes, which 32 bits do not hold.
  ExpectRefused(refusal(16384, 16384, Format::kRgba32F), absl::StatusCode::kResourceExhausted,
                "found 4294967296 bytes of GPU memory beside 0 in use, need at most 1073741824");
  EXPECT_TRUE(Texture::Create(*context_, {.width = 1, .height = 1}).ok());
  EXPECT_TRUE(Texture::Create(*context_, {.width = 16384, .height = 1}).ok());
}

TEST_F(MemoryTest, EverySampleOfATargetCounts) {
  UseBytes(1 << 20);
  const FramebufferOptions options{.width = 128, .height = 128, .samples = 4};
  const absl::Status status = Framebuffer::Create(*context_, options).status();
  // The colours take the whole of it, so that there is none for depths.
  ExpectRefused(status, absl::StatusCode::kResourceExhausted,
                "found 262144 bytes of GPU memory beside 1048576 in use");
}

TEST_F(MemoryTest, BuffersCountUntilTheyGo) {
  UseBytes(1000);
  {
    auto half = Buffer::Create(*context_, 500);
    ASSERT_TRUE(half.ok()) << half.status();
    Buffer moved = *std::move(half);
    EXPECT_EQ(context_->memory().used(), 500u);
    const auto more = Buffer::Create(*context_, 501);
    EXPECT_EQ(FaultOf(more.status()), Fault::kOverBudget);
    EXPECT_EQ(context_->TakeFault(), Fault::kOverBudget);
    EXPECT_EQ(context_->TakeFault(), Fault::kNone);
    EXPECT_TRUE(Buffer::Create(*context_, 500).ok());
  }
  ExpectRefused(Buffer::Create(*context_, SIZE_MAX).status(), absl::StatusCode::kResourceExhausted,
                "found 18446744073709551615 bytes");
}

TEST_F(MemoryTest, MayOutliveItsContext) {
  auto context = Context::Create({.device = TestDevice(), .max_memory_bytes = 64}).value();
  auto kept = Buffer::Create(*context, 64);
  ASSERT_TRUE(kept.ok());
  context.reset();
}

}  // namespace
}  // namespace penumbra::gl
