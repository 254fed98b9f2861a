#include "server/results/result_origin.h"

#include <elf.h>
#include <link.h>

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "server/random_bytes.h"

namespace penumbra {
namespace {

// Notes are records of a name and a description, each filled up to four bytes.
std::string BuildIdIn(std::string_view notes) {
  const auto filled = [](size_t bytes) { return (bytes + 3) / 4 * 4; };
  while (notes.size() >= sizeof(ElfW(Nhdr))) {
    ElfW(Nhdr) head;
    std::memcpy(&head, notes.data(), sizeof(head));
    const size_t description = sizeof(head) + filled(head.n_namesz);
    const size_t end = description + filled(head.n_descsz);
    if (end > notes.size()) break;
    if (head.n_type == NT_GNU_BUILD_ID) {
      return std::string(notes.substr(description, head.n_descsz));
    }
    notes.remove_prefix(end);
  }
  return "";
}

// Called for each object in memory, the program itself first.
int ReadBuildId(dl_phdr_info* object, size_t /*size*/, void* ids) {
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const auto& segment = object->dlpi_phdr[i];
    if (segment.p_type != PT_NOTE) continue;
    const auto* at = reinterpret_cast<const char*>(object->dlpi_addr + segment.p_vaddr);
    std::string id = BuildIdIn({at, segment.p_memsz});
    if (!id.empty()) static_cast<std::vector<std::string>*>(ids)->push_back(std::move(id));
  }
  return 0;
}

// In an order of their own: a driver may be loaded earlier or later.
std::string BuildIds() {
  std::vector<std::string> ids;
  dl_iterate_phdr(ReadBuildId, &ids);
  if (ids.empty()) return RandomBytes(16);
  std::sort(ids.begin(), ids.end());
  return absl::StrJoin(ids, "\n");
}

// Those between which the libraries choose that compute.
std::string Instructions() {
  std::string has;
#ifdef __x86_64__
  for (const bool one :
       {__builtin_cpu_supports("sse4.2") != 0, __builtin_cpu_supports("avx") != 0,
        __builtin_cpu_supports("avx2") != 0, __builtin_cpu_supports("fma") != 0,
        __builtin_cpu_supports("avx512f") != 0, __builtin_cpu_supports("avx512bw") != 0,
        __builtin_cpu_supports("avx512dq") != 0, __builtin_cpu_supports("avx512vl") != 0}) {
    has += one ? '1' : '0';
  }
#endif
  return has;
}

}  // namespace

std::string ResultOrigin(const v1::GlInfo& gl) {
  // Libraries that come later, of names and addresses for instance, compute nothing.
  static const std::string build_ids = BuildIds();
  return absl::StrCat(build_ids, "\n", Instructions(), "\n", gl.vendor(), "\n", gl.renderer(), "\n",
                      gl.version());
}

}  // namespace penumbra
