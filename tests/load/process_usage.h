// What a process has used, as the system counts it.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>

namespace penumbra::load {

struct ProcessUsage {
  double cpu_seconds = 0;  // of all its threads, in the kernel too
  uint64_t resident_bytes = 0;
};

// Of a process that runs; zeroes of one that does not.
inline ProcessUsage UsageOf(pid_t pid) {
  ProcessUsage usage;
  const std::string folder = "/proc/" + std::to_string(pid);
  std::string line;
  std::getline(std::ifstream(folder + "/stat") >> std::ws, line);
  // The name, in brackets, may hold anything.
  std::istringstream fields(line.substr(line.rfind(')') + 1));
  std::string skipped;
  for (int i = 3; i < 14; ++i) fields >> skipped;
  uint64_t user = 0, system = 0;
  fields >> user >> system;
  usage.cpu_seconds =
      static_cast<double>(user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
  uint64_t total = 0, resident = 0;
  std::ifstream(folder + "/statm") >> total >> resident;
  usage.resident_bytes = resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  return usage;
}

}  // namespace penumbra::load
