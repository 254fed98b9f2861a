#include "client/import/ply/ply_header.h"

#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/import/source_file.h"

namespace penumbra::ply {
namespace {

// Far more than any scanner writes; a header this long is no header.
constexpr int kMaxLines = 1000;

std::optional<Scalar> ParseScalar(absl::string_view word) {
  static constexpr std::array<std::pair<std::string_view, Scalar>, 16> kNames = {{
      {"char", Scalar::kInt8},
      {"int8", Scalar::kInt8},
      {"uchar", Scalar::kUint8},
      {"uint8", Scalar::kUint8},
      {"short", Scalar::kInt16},
      {"int16", Scalar::kInt16},
      {"ushort", Scalar::kUint16},
      {"uint16", Scalar::kUint16},
      {"int", Scalar::kInt32},
      {"int32", Scalar::kInt32},
      {"uint", Scalar::kUint32},
      {"uint32", Scalar::kUint32},
      {"float", Scalar::kFloat},
      {"float32", Scalar::kFloat},
      {"double", Scalar::kDouble},
      {"float64", Scalar::kDouble},
  }};
  for (const auto& [name, type] : kNames) {
    if (std::string_view(word.data(), word.size()) == name) return type;
  }
  return std::nullopt;
}

using Words = std::vector<absl::string_view>;

std::optional<Format> ParseFormat(const Words& words) {
  if (words.size() != 3 || words[2] != "1.0") return std::nullopt;
  if (words[1] == "ascii") return Format::kAscii;
  if (words[1] == "binary_little_endian") return Format::kBinaryLittleEndian;
  if (words[1] == "binary_big_endian") return Format::kBinaryBigEndian;
  return std::nullopt;
}

std::optional<Element> ParseElement(const Words& words, size_t file_bytes) {
  Element element;
  if (words.size() != 3 || !absl::SimpleAtoi(words[2], &element.count)) return std::nullopt;
  // Every element takes at least a byte, if it has properties; those without are refused later.
  if (element.count > file_bytes) return std::nullopt;
  element.name = std::string(words[1]);
  return element;
}

std::optional<Property> ParseProperty(const Words& words) {
  Property property;
  property.is_list = words.size() == 5 && words[1] == "list";
  if (!property.is_list && words.size() != 3) return std::nullopt;
  const std::optional<Scalar> type = ParseScalar(words[words.size() - 2]);
  if (!type) return std::nullopt;
  property.type = *type;
  property.name = std::string(words.back());
  if (property.is_list) {
    const std::optional<Scalar> count_type = ParseScalar(words[2]);
    if (!count_type || *count_type == Scalar::kFloat || *count_type == Scalar::kDouble) {
      return std::nullopt;
    }
    property.count_type = *count_type;
  }
  return property;
}

// Whether the line was understood; `header` grows by what it says.
bool ReadLine(const Words& words, size_t file_bytes, bool& has_format, Header& header) {
  if (words.empty() || words[0] == "comment" || words[0] == "obj_info") return true;
  if (words[0] == "format") {
    const std::optional<Format> format = ParseFormat(words);
    if (!format || has_format) return false;
    header.format = *format;
    has_format = true;
    return true;
  }
  if (words[0] == "element") {
    std::optional<Element> element = ParseElement(words, file_bytes);
    if (element) header.elements.push_back(*std::move(element));
    return element.has_value();
  }
  if (words[0] != "property" || header.elements.empty()) return false;
  std::optional<Property> property = ParseProperty(words);
  if (property) header.elements.back().properties.push_back(*std::move(property));
  return property.has_value();
}

absl::Status CheckElements(const Header& header) {
  for (const Element& element : header.elements) {
    if (element.properties.empty() && element.count > 0) {
      return Malformed("PLY", absl::StrCat("element ", Quoted(element.name)),
                       "found no properties, need at least one");
    }
  }
  return absl::OkStatus();
}

}  // namespace

size_t BytesOf(Scalar type) {
  switch (type) {
    case Scalar::kInt8:
    case Scalar::kUint8:
      return 1;
    case Scalar::kInt16:
    case Scalar::kUint16:
      return 2;
    case Scalar::kDouble:
      return 8;
    default:
      return 4;
  }
}

absl::StatusOr<Header> ParseHeader(std::span<const std::byte> file) {
  const std::string_view text = AsText(file);
  Header header;
  bool has_format = false;
  // Old Macs ended lines with a carriage return alone.
  const size_t first_end = text.substr(0, 80).find_first_of("\r\n");
  const bool is_mac = first_end != std::string_view::npos && text[first_end] == '\r' &&
                      !text.substr(first_end + 1).starts_with('\n');
  const char line_end = is_mac ? '\r' : '\n';
  for (int line_number = 1; line_number <= kMaxLines; ++line_number) {
    const size_t end = text.find(line_end, header.bytes);
    if (end == std::string_view::npos) {
      return Malformed("PLY", absl::StrCat("header line ", line_number),
                       "found the end of the file, need end_header");
    }
    const std::string_view line = text.substr(header.bytes, end - header.bytes);
    header.bytes = end + 1;
    const Words words = absl::StrSplit(absl::string_view(line.data(), line.size()),
                                       absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    if (line_number == 1) {
      if (words.size() == 1 && words[0] == "ply") continue;
      return Malformed("PLY", "header line 1",
                       absl::StrCat("found ", Quoted(line), ", need \"ply\""));
    }
    if (words.size() == 1 && words[0] == "end_header") {
      if (!has_format) return Malformed("PLY", "header", "found no format line, need one");
      absl::Status status = CheckElements(header);
      if (!status.ok()) return status;
      return header;
    }
    if (!ReadLine(words, file.size(), has_format, header)) {
      return Malformed("PLY", absl::StrCat("header line ", line_number),
                       absl::StrCat("found ", Quoted(line),
                                    ", need a format, element or property that the file has room "
                                    "for"));
    }
  }
  return Malformed("PLY", "header",
                   absl::StrCat("found more than ", kMaxLines, " lines, need end_header"));
}

}  // namespace penumbra::ply
