// Row D07 of the catalogue: a system that writes less than it was asked to, or is interrupted.

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <string>

#include "server/storage/durable_file.h"
#include "server/storage/scene_file.h"
#include "tests/support/scene_records.h"
#include "tests/support/temporary_folder.h"

namespace {

std::atomic<bool> is_hasty = false;
std::atomic<int> hurried = 0;

// Of every three calls one is interrupted; the others do a part of what is asked.
bool IsInterrupted() {
  if (!is_hasty) return false;
  errno = EINTR;
  return hurried++ % 3 == 0;
}
size_t Part(size_t count) { return is_hasty ? std::max<size_t>(1, count / 3) : count; }

// The function of this name that the program would have called without those below.
template <typename Function>
Function Next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

// In place of the system's, for the whole program.
extern "C" ssize_t write(int fd, const void* data, size_t count) {
  static const auto next = Next<ssize_t (*)(int, const void*, size_t)>("write");
  return IsInterrupted() ? -1 : next(fd, data, Part(count));
}

extern "C" ssize_t read(int fd, void* data, size_t count) {
  static const auto next = Next<ssize_t (*)(int, void*, size_t)>("read");
  return IsInterrupted() ? -1 : next(fd, data, Part(count));
}

namespace penumbra::testing {
namespace {

ssize_t HastyWrite(int fd, const void* data, size_t count, off64_t at) {
  return IsInterrupted() ? -1 : ::pwrite64(fd, data, Part(count), at);
}
ssize_t HastyRead(int fd, void* data, size_t count, off64_t at) {
  return IsInterrupted() ? -1 : ::pread64(fd, data, Part(count), at);
}

class ShortWritesTest : public ::testing::Test {
 protected:
  ShortWritesTest() {
    Install("pwrite64", reinterpret_cast<sqlite3_syscall_ptr>(HastyWrite));
    Install("pread64", reinterpret_cast<sqlite3_syscall_ptr>(HastyRead));
    is_hasty = true;
    hurried = 0;
  }
  ~ShortWritesTest() override {
    is_hasty = false;
    Install("pwrite64", nullptr);
    Install("pread64", nullptr);
  }
  // SQLite's own way to have its calls of the system replaced.
  static void Install(const char* name, sqlite3_syscall_ptr call) {
    sqlite3_vfs* system = sqlite3_vfs_find(nullptr);
    EXPECT_EQ(system->xSetSystemCall(system, name, call), SQLITE_OK) << name;
  }

  TemporaryFolder folder_;
};

TEST_F(ShortWritesTest, D07AFileIsWrittenToItsEndAndReadToIt) {
  std::string content;
  for (int i = 0; i < 20'000; ++i) content += std::to_string(i) + "\n";
  ASSERT_EQ(WriteDurably(folder_ / "file", content), absl::OkStatus());
  EXPECT_EQ(ReadFileIfThere(folder_ / "file").value(), content);
  EXPECT_GT(hurried, 20);
  is_hasty = false;
  EXPECT_EQ(ReadFileIfThere(folder_ / "file").value(), content);
}

TEST_F(ShortWritesTest, D07ASceneIsWrittenWholeAndReadBack) {
  {
    auto file = SceneFile::Create(folder_ / "scene.db", StudioIdentity(), {}).value();
    for (Revision revision = 1; revision <= 20; ++revision) {
      ASSERT_EQ(file->Append(CommitsBetween(revision, revision)), absl::OkStatus());
    }
    ASSERT_EQ(file->AppendSnapshot(SnapshotAt(20), {}), absl::OkStatus());
  }
  EXPECT_GT(hurried, 100);
  for (const bool hastily : {true, false}) {
    is_hasty = hastily;
    auto file = SceneFile::Open(folder_ / "scene.db", {}).value();
    EXPECT_EQ(file->head().revision, 20u);
    EXPECT_EQ(TextOf(file->StateAt(20).value()), TextOf({.snapshot = SnapshotAt(20)}));
    EXPECT_EQ(file->History(0).value().size(), 20u);
  }
}

}  // namespace
}  // namespace penumbra::testing
