#include "server/storage/heads_file.h"

#include <cstdint>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "server/storage/durable_file.h"
#include "server/storage/scene_rows.h"

namespace penumbra {
namespace {

constexpr char kTitle[] = "penumbra heads 1\n";
constexpr char kSeal[] = "sha256 ";

}  // namespace

absl::Status WriteHeads(const std::string& path, const KnownHeads& heads) {
  std::string text = kTitle;
  for (const auto& [id, known] : heads) {
    absl::StrAppend(&text, absl::BytesToHexString(known.incarnation), " ", known.revision, " ", id,
                    "\n");
  }
  const std::string seal = HashOfBytes(text).hex();
  absl::StrAppend(&text, kSeal, seal, "\n");
  return WriteDurably(path, text);
}

absl::StatusOr<KnownHeads> ReadHeads(const std::string& path) {
  const auto text = ReadFileIfThere(path);
  if (!text.ok()) return text.status();
  KnownHeads heads;
  if (text->empty()) return heads;
  const size_t seal_at = text->rfind(kSeal);
  if (seal_at == std::string::npos ||
      text->substr(seal_at) !=
          absl::StrCat(kSeal, HashOfBytes(text->substr(0, seal_at)).hex(), "\n")) {
    return Damaged("a seal that does not fit");
  }
  for (const absl::string_view line :
       absl::StrSplit(text->substr(0, seal_at), '\n', absl::SkipEmpty())) {
    const std::vector<std::string> words = absl::StrSplit(line, ' ');
    uint64_t revision = 0;
    if (words.size() != 3 || !absl::SimpleAtoi(words[1], &revision)) continue;  // the title
    heads[words[2]] = {.incarnation = absl::HexStringToBytes(words[0]), .revision = revision};
  }
  return heads;
}

}  // namespace penumbra
