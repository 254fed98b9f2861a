#include "server/address_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "render/scene/field_error.h"
#include "server/listen_address.h"

namespace penumbra {
namespace {

bool WriteLine(const std::string& path, const std::string& line) {
  std::ofstream out(path);
  out << line << "\n" << std::flush;
  return out.good();
}

}  // namespace

std::optional<AddressFile::Identity> AddressFile::IdentityOf(const std::string& path) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0 || !S_ISREG(found.st_mode)) return std::nullopt;
  return Identity{found.st_dev, found.st_ino, found.st_mtim.tv_sec, found.st_mtim.tv_nsec};
}

void AddressFile::RemoveIfDead() const {
  if (!IdentityOf(path_)) return;
  std::string address;
  std::ifstream file(path_);
  std::getline(file, address);
  const bool is_dead =
      CheckListenAddress(address, /*has_tls=*/true).ok() && TryListening(address).ok();
  if (is_dead) ::unlink(path_.c_str());
}

absl::Status AddressFile::Write(const std::string& address) {
  if (path_.empty()) return absl::OkStatus();
  const auto failed = [this] {
    return FieldError(absl::StatusCode::kUnavailable, "CANNOT_WRITE", "address-file",
                      "cannot write " + path_ + ", need a writable file");
  };
  std::error_code error;
  // A link that leads nowhere yet is there too.
  const bool is_there = std::filesystem::exists(std::filesystem::symlink_status(path_, error));
  if (is_there && !IdentityOf(path_)) {
    return WriteLine(path_, address) ? absl::OkStatus() : failed();
  }
  const std::string beside = path_ + "." + std::to_string(::getpid());
  const bool is_written = WriteLine(beside, address);
  written_ = IdentityOf(beside);
  if (!is_written || std::rename(beside.c_str(), path_.c_str()) != 0) {
    ::unlink(beside.c_str());
    written_.reset();
    return failed();
  }
  return absl::OkStatus();
}

void AddressFile::Remove() const {
  if (written_ && IdentityOf(path_) == written_) ::unlink(path_.c_str());
}

}  // namespace penumbra
