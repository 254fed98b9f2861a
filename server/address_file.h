// The file that says where a server listens, for those who start it and have to wait for it.
//
//   AddressFile file(path);
//   file.RemoveIfDead();
//   if (auto status = file.Write(server.address()); !status.ok()) …  // once the server listens
//   file.Remove();                                                   // when it no longer does
#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"

namespace penumbra {

class AddressFile {
 public:
  // Nothing happens where `path` is empty.
  explicit AddressFile(std::string path) : path_(std::move(path)) {}

  // Removes the file of an earlier server that has ended without removing it: it would send clients
  // nowhere.
  void RemoveIfDead() const;

  // Puts the address there in one go: whoever reads the file finds all of it. A terminal or a pipe
  // is written to as it is.
  //
  // Errors  kUnavailable: a path that cannot be written
  absl::Status Write(const std::string& address);

  // Unless another server has put its own there since.
  void Remove() const;

 private:
  // What tells the file written here from one that took its place.
  struct Identity {
    unsigned long device = 0;
    unsigned long inode = 0;
    long seconds = 0;
    long nanoseconds = 0;

    friend bool operator==(const Identity&, const Identity&) = default;
  };
  static std::optional<Identity> IdentityOf(const std::string& path);

  const std::string path_;
  std::optional<Identity> written_;
};

}  // namespace penumbra
