#include "render/gl/context.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <thread>

#include "render/gl/buffer.h"
#include "tests/support/test_device.h"

namespace penumbra::gl {
namespace {

using ::testing::HasSubstr;

TEST(DisplayTest, SoftwareDeviceIsEnumerated) {
  const auto devices = Display::Devices();
  ASSERT_TRUE(devices.ok()) << devices.status();
  int software = 0;
  for (const DeviceInfo& device : *devices) software += device.is_software;
  EXPECT_EQ(software, 1);
}

TEST(DisplayTest, OpensByIndexAndByPartOfTheName) {
  const auto devices = Display::Devices();
  ASSERT_TRUE(devices.ok()) << devices.status();
  const auto by_name = Display::Open("SOFT");
  ASSERT_TRUE(by_name.ok()) << by_name.status();
  EXPECT_TRUE((*by_name)->device().is_software);
  const auto by_index = Display::Open(std::to_string((*by_name)->device().index));
  ASSERT_TRUE(by_index.ok()) << by_index.status();
  EXPECT_EQ(*by_index, *by_name) << "one display for each device of the process";
}

TEST(DisplayTest, UnknownDeviceNamesThoseThereAre) {
  const auto display = Display::Open("voodoo2");
  EXPECT_EQ(display.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(display.status().message()), HasSubstr("found no \"voodoo2\""));
  EXPECT_THAT(std::string(display.status().message()), HasSubstr("software"));
}

// The last rung of the ladder, where EGL lists no devices.
TEST(DisplayTest, SurfacelessPlatformWorksToo) {
  const auto context = Context::Create({.device = "surfaceless"});
  ASSERT_TRUE(context.ok()) << context.status();
  EXPECT_EQ((*context)->info().device.index, -1);
  EXPECT_TRUE((*context)->Check("the surfaceless platform").ok());
}

TEST(DisplayTest, IndexPastTheEndIsNotFound) {
  EXPECT_EQ(Display::Open("99").status().code(), absl::StatusCode::kNotFound);
}

// A process of its own, for EGL reads its configuration once.
TEST(DisplayDeathTest, NoDriverIsAnErrorAndNotACrash) {
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  EXPECT_EXIT(
      {
        setenv("__EGL_VENDOR_LIBRARY_DIRS", "/nonexistent", 1);
        const auto context = Context::Create();
        const bool as_wanted = context.status().code() == absl::StatusCode::kUnavailable;
        fprintf(stderr, "%s\n", context.status().ToString().c_str());
        _exit(as_wanted ? 0 : 1);
      },
      testing::ExitedWithCode(0), "no usable device");
}

TEST(ContextTest, TellsWhatItRunsOn) {
  const auto context = Context::Create({.device = TestDevice()});
  ASSERT_TRUE(context.ok()) << context.status();
  const ContextInfo& info = (*context)->info();
  EXPECT_TRUE(info.is_software);
  EXPECT_TRUE(info.is_robust);
  EXPECT_THAT(info.version, HasSubstr("Core Profile"));
  EXPECT_FALSE(info.vendor.empty());
  EXPECT_FALSE(info.renderer.empty());
  EXPECT_GE(info.max_texture_side, 16384) << "what OpenGL 4.5 promises";
  EXPECT_GE(info.max_samples, 4);
  EXPECT_GE(info.max_storage_bytes, 1 << 24);
}

TEST(ContextTest, OtherThreadsAreRefused) {
  const auto context = Context::Create({.device = TestDevice()});
  ASSERT_TRUE(context.ok()) << context.status();
  absl::Status status;
  std::thread([&] { status = (*context)->MakeCurrent(); }).join();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("another thread"));
  EXPECT_TRUE((*context)->MakeCurrent().ok());
}

TEST(ContextTest, ALossIsSeenByEveryCheck) {
  const auto context = Context::Create({.device = TestDevice()});
  ASSERT_TRUE(context.ok()) << context.status();
  EXPECT_TRUE((*context)->Check("drawing").ok());
  (*context)->SimulateLoss();
  EXPECT_TRUE((*context)->IsLost());
  const absl::Status status = (*context)->Check("drawing");
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr("drawing: the GL context is lost"));
}

TEST(ContextTest, ObjectsAreCountedAndMayOutliveTheirContext) {
  auto context = Context::Create({.device = TestDevice()});
  ASSERT_TRUE(context.ok()) << context.status();
  auto kept = Buffer::Create(**context, 16);
  ASSERT_TRUE(kept.ok()) << kept.status();
  {
    auto dropped = Buffer::Create(**context, 16);
    ASSERT_TRUE(dropped.ok()) << dropped.status();
    EXPECT_EQ((*context)->object_count(), 2);
    Buffer moved = *std::move(dropped);
    EXPECT_EQ((*context)->object_count(), 2) << "moving makes no object";
  }
  EXPECT_EQ((*context)->object_count(), 1);
  context->reset();
}

TEST(ContextTest, ObjectsOfOneContextDoNotTouchAnother) {
  auto first = Context::Create({.device = TestDevice()});
  auto second = Context::Create({.device = TestDevice()});
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_NE((*first)->serial(), (*second)->serial());
  const uint32_t word = 0x12345678;
  const auto bytes = std::as_bytes(std::span(&word, 1));
  auto in_first = Buffer::Create(**first, bytes);
  auto in_second = Buffer::Create(**second, bytes);
  ASSERT_TRUE(in_first.ok() && in_second.ok());
  // The two may have equal names; dropping one deletes it in its own context alone.
  *in_first = Buffer();
  uint32_t read = 0;
  ASSERT_TRUE(in_second->Read(**second, 0, std::as_writable_bytes(std::span(&read, 1))).ok());
  EXPECT_EQ(read, word);
}

}  // namespace
}  // namespace penumbra::gl
