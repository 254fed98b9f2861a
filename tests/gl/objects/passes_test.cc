// What drawing in several passes takes: whole numbers united bit by bit, sums, parts of a target,
// and reading back without waiting at once.
#include <gtest/gtest.h>

#include <vector>

#include "render/gl/draw.h"
#include "render/gl/lazy_worker.h"
#include "render/gl/readback.h"
#include "tests/gl/display/software_context.h"
#include "tests/support/test_device.h"

namespace penumbra::gl {
namespace {

// A triangle over all of clip space; instance i is painted in colour paint << i.
constexpr char kVertex[] = R"(
flat out int number;
void main() {
  number = gl_InstanceID;
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
})";
constexpr char kBits[] = R"(
flat in int number;
uniform uint paint;
layout(location = 0) out uvec2 color;
void main() { color = uvec2(paint << number, paint); })";
constexpr char kSum[] = R"(
layout(binding = 1) uniform usampler2D bits;
layout(location = 0) out float color;
void main() {
  uvec2 here = texelFetch(bits, ivec2(gl_FragCoord.xy), 0).rg;
  color = float(here.r) + 1000.0 * float(here.g);
})";

class PassesTest : public SoftwareContextTest {
 protected:
  void SetUp() override {
    SoftwareContextTest::SetUp();
    bits_ = Framebuffer::Create(
                *context_, {.width = 6, .height = 4, .color = Format::kRg32Ui, .has_depth = false})
                .value();
    sums_ = Framebuffer::Create(
                *context_, {.width = 6, .height = 4, .color = Format::kR32F, .has_depth = false})
                .value();
    draw_bits_ = Program::Create(*context_, {.vertex = kVertex, .fragment = kBits}).value();
    draw_sums_ = Program::Create(*context_, {.vertex = kVertex, .fragment = kSum}).value();
    vertices_ = VertexArray::Create(*context_).value();
    bits_.ClearToZeros(*context_);
  }

  void DrawBits(uint32_t paint, const PixelArea& area) {
    draw_bits_.Set(*context_, "paint", paint);
    Draw(*context_, {.program = draw_bits_,
                     .vertices = vertices_,
                     .target = bits_,
                     .count = 3,
                     .depth_test = DepthTest::kNone,
                     .combine = Combine::kOr,
                     .instances = 3,
                     .area = area});
  }
  void AddBitsToSums() {
    bits_.BindColor(*context_, 1);
    Draw(*context_, {.program = draw_sums_,
                     .vertices = vertices_,
                     .target = sums_,
                     .count = 3,
                     .depth_test = DepthTest::kNone,
                     .combine = Combine::kAdd});
  }

  Framebuffer bits_, sums_;
  Program draw_bits_, draw_sums_;
  VertexArray vertices_;
};

TEST_F(PassesTest, BitsAreUnitedAndSumsAdded) {
  DrawBits(1, {.x = 1, .y = 1, .width = 4, .height = 2});  // 1, 2 and 4
  DrawBits(4, {.x = 1, .y = 1, .width = 1, .height = 1});  // 4, 8 and 16
  sums_.Clear(*context_, Vec4(0.5f));
  AddBitsToSums();
  AddBitsToSums();
  auto all = Readback::Start(*context_, sums_, {0, 0, 6, 4}, 1);
  ASSERT_TRUE(all.ok()) << all.status();
  sums_.Clear(*context_, Vec4(7));  // comes after what was asked for
  auto part = Readback::Start(*context_, sums_, {4, 3, 2, 1}, 1);
  ASSERT_TRUE(part.ok()) << part.status();
  const auto pixels = all->Wait(*context_);
  ASSERT_TRUE(pixels.ok()) << pixels.status();
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 6; ++x) {
      float expected = 0.5f;
      if (x >= 1 && x < 5 && y >= 1 && y < 3) expected = 0.5f + 2 * (7 + 1000);
      if (x == 1 && y == 1) expected = 0.5f + 2 * (31 + 5000);
      EXPECT_EQ((*pixels)[6 * y + x], expected) << x << ", " << y;
    }
  }
  EXPECT_EQ(part->Wait(*context_).value(), std::vector<float>({7, 7}));
}

TEST_F(PassesTest, ReadbackKnowsOneAndFourChannels) {
  auto target = Framebuffer::Create(*context_, {.width = 2, .height = 1, .has_depth = false});
  ASSERT_TRUE(target.ok());
  target->Clear(*context_, Vec4(1, 2, 3, 4));
  auto readback = Readback::Start(*context_, *target, {0, 0, 2, 1}, 4);
  ASSERT_TRUE(readback.ok());
  EXPECT_EQ(readback->Wait(*context_).value(), std::vector<float>({1, 2, 3, 4, 1, 2, 3, 4}));
  EXPECT_EQ(Readback::Start(*context_, *target, {0, 0, 2, 1}, 3).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(PassesTest, ALostContextIsToldWhileReading) {
  auto target = Framebuffer::Create(*context_, {.width = 2, .height = 1, .has_depth = false});
  ASSERT_TRUE(target.ok());
  auto lost = Context::Create({.device = TestDevice()}).value();
  auto other = Framebuffer::Create(*lost, {.width = 2, .height = 1, .has_depth = false});
  auto readback = Readback::Start(*lost, *other, {0, 0, 2, 1}, 4);
  ASSERT_TRUE(readback.ok());
  lost->SimulateLoss();
  EXPECT_EQ(readback->Wait(*lost).status().code(), absl::StatusCode::kUnavailable);
}

TEST_F(PassesTest, WhatIsKeptGoesWithTheContext) {
  static constexpr char kOwner = 0, kOther = 0;
  auto context = Context::Create({.device = TestDevice()}).value();
  EXPECT_EQ(context->Kept(&kOwner), nullptr);
  const auto kept = std::make_shared<int>(5);
  context->Kept(&kOwner) = kept;
  EXPECT_EQ(context->Kept(&kOwner), kept);
  EXPECT_EQ(context->Kept(&kOther), nullptr);
  EXPECT_EQ(kept.use_count(), 2);
  context.reset();
  EXPECT_EQ(kept.use_count(), 1);
}

TEST(LazyWorkerTest, IsMadeOnceAndSaysWhyNot) {
  LazyWorker lazy({.context = {.device = TestDevice()}});
  const auto worker = lazy.Get();
  ASSERT_TRUE(worker.ok()) << worker.status();
  EXPECT_EQ(lazy.Get().value(), *worker);
  LazyWorker nothing({.context = {.device = "voodoo2"}});
  EXPECT_EQ(nothing.Get().status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(nothing.Get().status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace penumbra::gl
