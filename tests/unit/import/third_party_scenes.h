// The folder of models by other authors: PENUMBRA_SCENES, or shared/scenes beside the sources.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace penumbra {

inline std::filesystem::path ScenesFolder() {
  const char* folder = std::getenv("PENUMBRA_SCENES");
  return folder == nullptr ? PENUMBRA_DEFAULT_SCENES : folder;
}

class ThirdPartyScenes : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(ScenesFolder())) {
      GTEST_SKIP() << "no folder " << ScenesFolder() << "; set PENUMBRA_SCENES";
    }
  }
};

}  // namespace penumbra
