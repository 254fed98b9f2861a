#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "render/gl/buffer.h"
#include "render/gl/context.h"
#include "render/gl/draw.h"
#include "render/gl/framebuffer.h"
#include "render/gl/program.h"
#include "render/gl/query.h"
#include "render/gl/texture.h"
#include "render/gl/vertex_array.h"
#include "tests/support/test_device.h"

namespace penumbra::gl {
namespace {

using ::testing::HasSubstr;

constexpr char kVertexGlsl[] = R"(
layout(location = 0) in vec3 position;
uniform float depth;
void main() { gl_Position = vec4(position.xy, depth, 1.0); })";
constexpr char kFragmentGlsl[] = R"(
layout(location = 0) out vec4 color;
uniform vec4 paint;
void main() { color = paint * kGain; })";

class ObjectsTest : public testing::Test {
 protected:
  void SetUp() override {
    auto context = Context::Create({.device = TestDevice()});
    ASSERT_TRUE(context.ok()) << context.status();
    context_ = *std::move(context);
  }
  void TearDown() override {
    EXPECT_THAT(context_->TakeMessages(), testing::IsEmpty());
    EXPECT_TRUE(context_->Check("the test").ok());
  }

  std::unique_ptr<Context> context_;
};

TEST_F(ObjectsTest, BufferKeepsWhatIsWritten) {
  auto buffer = Buffer::Create(*context_, 4 * sizeof(float));
  ASSERT_TRUE(buffer.ok()) << buffer.status();
  const std::array<float, 2> written = {1.5f, -2.5f};
  ASSERT_TRUE(buffer->Write(*context_, sizeof(float), std::as_bytes(std::span(written))).ok());
  std::array<float, 4> read = {9, 9, 9, 9};
  ASSERT_TRUE(buffer->Read(*context_, 0, std::as_writable_bytes(std::span(read))).ok());
  EXPECT_THAT(read, testing::ElementsAre(0, 1.5f, -2.5f, 0));
}

TEST_F(ObjectsTest, BufferRefusesBytesPastItsEnd) {
  auto buffer = Buffer::Create(*context_, 4);
  ASSERT_TRUE(buffer.ok()) << buffer.status();
  const std::array<std::byte, 4> bytes{};
  EXPECT_EQ(buffer->Write(*context_, 1, bytes).code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(buffer->Write(*context_, SIZE_MAX, bytes).code(), absl::StatusCode::kOutOfRange);
}

TEST_F(ObjectsTest, AnEmptyBufferIsAllowed) {
  auto buffer = Buffer::Create(*context_, 0);
  ASSERT_TRUE(buffer.ok()) << buffer.status();
  EXPECT_EQ(buffer->size(), 0u);
}

TEST_F(ObjectsTest, TextureRefusesSidesItCannotHave) {
  const auto texture = Texture::Create(*context_, {.width = 0, .height = 4});
  EXPECT_EQ(texture.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(texture.status().message()), HasSubstr("found 0 × 4"));
  EXPECT_FALSE(Texture::Create(*context_, {.width = 1 << 20, .height = 1}).ok());
}

TEST_F(ObjectsTest, CompilerErrorsCarryTheLog) {
  const auto program = Program::Create(
      *context_, {.vertex = "void main() { nonsense; }", .fragment = "void main(){}"});
  EXPECT_EQ(program.status().code(), absl::StatusCode::kInternal);
  EXPECT_THAT(std::string(program.status().message()), HasSubstr("vertex shader"));
  EXPECT_THAT(std::string(program.status().message()), HasSubstr("nonsense"));
}

TEST_F(ObjectsTest, NearerHidesFartherInReversedDepth) {
  auto program = Program::Create(
      *context_,
      {.vertex = kVertexGlsl, .fragment = kFragmentGlsl, .constants = GlslConstant("kGain", 0.5)});
  ASSERT_TRUE(program.ok()) << program.status();
  auto target = Framebuffer::Create(*context_, {.width = 8, .height = 4, .samples = 4});
  ASSERT_TRUE(target.ok()) << target.status();
  const std::array<Vec3, 3> covering = {Vec3(-1, -1, 0), Vec3(3, -1, 0), Vec3(-1, 3, 0)};
  auto positions = Buffer::Create(*context_, std::as_bytes(std::span(covering)));
  auto vertices = VertexArray::Create(*context_);
  ASSERT_TRUE(positions.ok() && vertices.ok());
  vertices->SetFloats(*context_, 0, *positions, 3);

  target->Clear(*context_, Vec4(0));
  auto query = Query::Create(*context_, Query::Kind::kSamplesPassed);
  ASSERT_TRUE(query.ok()) << query.status();
  const DrawCall call = {.program = *program, .vertices = *vertices, .target = *target, .count = 3};
  program->Set(*context_, "depth", 0.7f);
  program->Set(*context_, "paint", Vec4(2, 4, 8, 2));
  Draw(*context_, call);
  program->Set(*context_, "depth", 0.3f);
  program->Set(*context_, "paint", Vec4(100));
  query->Begin(*context_);
  Draw(*context_, call);
  query->End(*context_);
  EXPECT_EQ(query->Wait(*context_), 0u) << "all of the farther triangle is hidden";
  const auto pixels = target->ReadPixels(*context_);
  ASSERT_TRUE(pixels.ok()) << pixels.status();
  ASSERT_EQ(pixels->size(), 32u);
  for (const Vec4& pixel : *pixels) EXPECT_EQ(pixel, Vec4(1, 2, 4, 1));
}

TEST_F(ObjectsTest, ComputeWritesStorage) {
  auto program = Program::Create(*context_, {.compute = R"(
layout(local_size_x = 16) in;
layout(std430, binding = 2) buffer Numbers { float numbers[]; };
void main() { numbers[gl_GlobalInvocationID.x] *= 3.0; })"});
  ASSERT_TRUE(program.ok()) << program.status();
  std::vector<float> numbers(64);
  for (size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<float>(i);
  auto buffer = Buffer::Create(*context_, std::as_bytes(std::span(numbers)));
  ASSERT_TRUE(buffer.ok()) << buffer.status();
  buffer->BindStorage(*context_, 2);
  Dispatch(*context_, *program, 4);
  ASSERT_TRUE(buffer->Read(*context_, 0, std::as_writable_bytes(std::span(numbers))).ok());
  for (size_t i = 0; i < numbers.size(); ++i) EXPECT_EQ(numbers[i], 3.0f * static_cast<float>(i));
}

}  // namespace
}  // namespace penumbra::gl
