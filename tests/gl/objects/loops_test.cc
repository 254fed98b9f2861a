// What our shaders rely on: 32,768 turns of all loops together (docs/conventions.md). llvmpipe ends
// every loop of a run after 65,535 turns in all.
#include <gtest/gtest.h>

#include "render/gl/buffer.h"
#include "render/gl/draw.h"
#include "render/gl/program.h"
#include "tests/gl/display/software_context.h"

namespace penumbra::gl {
namespace {

class LoopsTest : public SoftwareContextTest {
 protected:
  // How often the inner of two loops was passed.
  uint32_t Turns(uint32_t outer, uint32_t inner) {
    auto program = Program::Create(*context_, {.compute = R"(
layout(local_size_x = 1) in;
layout(std430, binding = 0) buffer Numbers { uint turns, outer, inner; };
void main() {
  uint sum = 0u;
  for (uint i = 0u; i < outer; ++i) {
    for (uint j = 0u; j < inner; ++j) sum += 1u + (turns & 1u);  // not to be foreseen
  }
  turns = sum;
})"});
    EXPECT_TRUE(program.ok()) << program.status();
    uint32_t numbers[3] = {0, outer, inner};
    auto buffer = Buffer::Create(*context_, std::as_bytes(std::span(numbers)));
    EXPECT_TRUE(buffer.ok()) << buffer.status();
    buffer->BindStorage(*context_, 0);
    Dispatch(*context_, *program, 1);
    EXPECT_TRUE(buffer->Read(*context_, 0, std::as_writable_bytes(std::span(numbers))).ok());
    return numbers[0];
  }
};

TEST_F(LoopsTest, AsManyTurnsAsWeAllowOurselvesAreMade) {
  EXPECT_EQ(Turns(1, 32'766), 32'766u);
  EXPECT_EQ(Turns(1, 65'530), 65'530u);
  EXPECT_EQ(Turns(180, 180), 32'400u);
}

// Where this fails a driver counts otherwise.
TEST_F(LoopsTest, OnLlvmpipeTheTurnsOfAllLoopsCountTogether) {
  if (context_->info().renderer.find("llvmpipe") == std::string::npos) {
    GTEST_SKIP() << "what llvmpipe does is of no other driver";
  }
  EXPECT_LT(Turns(1, 65'536), 65'536u);
  EXPECT_LT(Turns(300, 300), 90'000u);
}

}  // namespace
}  // namespace penumbra::gl
