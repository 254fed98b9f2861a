// The importers against damaged files: never a crash, a hang or a huge allocation, and every
// refusal names something. PENUMBRA_FUZZ_MUTATIONS sets how many damaged versions of each file are
// tried; PENUMBRA_FUZZ_KEEP=1 leaves the last one on the disk.
#include "tests/fuzz/kit/mutation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "client/import/import_scene.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMutations = 1500;
// The corpus' files are a few kilobytes; what a sanitizer keeps aside comes on top.
constexpr long kMaxResidentKilobytes = 1'500'000;

uint64_t MutationCount() {
  const char* count = std::getenv("PENUMBRA_FUZZ_MUTATIONS");
  return count == nullptr ? kMutations : std::strtoull(count, nullptr, 10);
}

std::string Contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

std::vector<fs::path> CorpusFiles() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(PENUMBRA_CORPUS)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

class ImportMutation : public testing::TestWithParam<fs::path> {
 protected:
  ImportMutation()
      : folder_(fs::temp_directory_path() / ("penumbra_import_fuzz_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
    for (const fs::path& file : CorpusFiles()) {
      fs::copy_file(file, folder_ / file.filename(), fs::copy_options::overwrite_existing);
    }
  }
  ~ImportMutation() override {
    if (std::getenv("PENUMBRA_FUZZ_KEEP") == nullptr) fs::remove_all(folder_);
  }

  // A material library is read through the model that names it.
  fs::path Entry() const {
    return GetParam().extension() == ".mtl" ? folder_ / "lamp.obj"
                                            : folder_ / GetParam().filename();
  }

  void Try(const std::string& bytes) {
    // Some file systems wait for the disk when a file is written over, but not for a new one.
    const fs::path damaged = folder_ / GetParam().filename();
    fs::remove(damaged);
    std::ofstream(damaged, std::ios::binary) << bytes;
    const absl::StatusOr<ImportedScene> imported = ImportScene(Entry());
    if (imported.ok()) {
      ++accepted_;
      // What is let through the scene must be able to judge.
      (void)Scene::Empty("fuzz")->Apply(ToSceneDelta(*imported));
    } else {
      ++refused_;
      EXPECT_FALSE(ErrorFieldPath(imported.status()).empty()) << imported.status();
      EXPECT_THAT(std::string(imported.status().message()), testing::HasSubstr("need"));
    }
  }

  fs::path folder_;
  int accepted_ = 0, refused_ = 0;
};

std::string NameOf(const testing::TestParamInfo<fs::path>& info) {
  std::string name = info.param.filename().string();
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Files, ImportMutation, testing::ValuesIn(CorpusFiles()), NameOf);

TEST_P(ImportMutation, TheWholeFileIsRead) {
  Try(Contents(GetParam()));
  EXPECT_EQ(accepted_, 1);
}

TEST_P(ImportMutation, EveryTruncationIsRefusedOrRead) {
  const std::string whole = Contents(GetParam());
  for (size_t length = 0; length < whole.size(); ++length) Try(whole.substr(0, length));
  // Text formats have no end mark, so some of their beginnings are files of their own.
  if (GetParam().extension() == ".glb") {
    EXPECT_EQ(accepted_, 0);
  }
}

TEST_P(ImportMutation, DamageIsRefusedOrRead) {
  const std::string whole = Contents(GetParam());
  for (uint64_t seed = 0; seed < MutationCount(); ++seed) Try(Mutated(whole, seed));
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  EXPECT_LT(usage.ru_maxrss, kMaxResidentKilobytes);
  // A fuzzer whose files are all refused at the door tests the door alone.
  EXPECT_GT(accepted_, 0);
  if (GetParam().extension() != ".mtl") {
    EXPECT_GT(refused_, 0);
  }
}

}  // namespace
}  // namespace penumbra
