// A context on the software device, which every test machine has.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "render/gl/context.h"
#include "tests/support/test_device.h"

namespace penumbra {

class SoftwareContextTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto context = gl::Context::Create({.device = TestDevice()});
    ASSERT_TRUE(context.ok()) << context.status();
    context_ = *std::move(context);
  }
  void TearDown() override {
    for (const std::string& message : context_->TakeMessages()) ADD_FAILURE() << message;
    EXPECT_TRUE(context_->Check("the test").ok());
  }

  std::unique_ptr<gl::Context> context_;
};

}  // namespace penumbra
