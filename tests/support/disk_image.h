// What a disk may hold after a loss of power: all that was synced, and of what was written since
// any part, in sectors of 512 bytes, whatever the order was.
//
//   DiskImage disk;
//   FaultyVfs vfs(&disk);       // which tells it of every write
//   disk.LosePower(random);     // the files are as such a disk has them
#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace penumbra::testing {

class DiskImage {
 public:
  // How much of what was not synced is there after all.
  enum class Luck { kNothing, kEverything, kSome };

  void OnOpen(const std::string& path);
  void OnWrite(const std::string& path, uint64_t at, std::string bytes);
  void OnTruncate(const std::string& path, uint64_t size);
  void OnSync(const std::string& path);
  // Whether the folder is synced after it; else it may be there again.
  void OnDelete(const std::string& path, bool is_synced);

  // Nobody has the files open. They are the disk's from here on.
  void LosePower(Luck luck, std::mt19937& random);

 private:
  struct Change {
    uint64_t at = 0;    // or the size to truncate to
    std::string bytes;  // empty: a truncation
  };
  struct File {
    std::string durable;
    std::vector<Change> changes;  // since the last sync
    bool is_known = false;        // to its folder: synced once
    bool is_deleted = false;
  };

  std::map<std::string, File> files_;
};

}  // namespace penumbra::testing
