// A file that whoever writes it waits for, as on a disk that has gone to sleep.
//
//   StalledFile stalled(folder / "owners.new");
//   …                     // who opens it does not come back
//   stalled.WakeUp();     // and fails then
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>

namespace penumbra::testing {

// A pipe, which is opened once somebody reads it, and cannot be synced.
class StalledFile {
 public:
  explicit StalledFile(std::string path) : path_(std::move(path)) {
    EXPECT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  }
  ~StalledFile() {
    if (reading_ >= 0) ::close(reading_);
  }
  StalledFile(const StalledFile&) = delete;
  StalledFile& operator=(const StalledFile&) = delete;

  void WakeUp() { reading_ = ::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC); }

 private:
  const std::string path_;
  int reading_ = -1;
};

}  // namespace penumbra::testing
