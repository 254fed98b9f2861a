#include "client/import/gltf/schema.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/import/source_file.h"

namespace penumbra::gltf {
namespace {

using nlohmann::json;

absl::string_view View(std::string_view text) { return {text.data(), text.size()}; }

// The value as it stands in the file, shortened.
std::string Found(const json& value) {
  if (value.is_object()) return "found an object";
  if (value.is_array()) return absl::StrCat("found an array of ", value.size());
  const std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  return absl::StrCat("found ", text.size() > 60 ? text.substr(0, 60) + "…" : text);
}

class Checker {
 public:
  Checker(json& document, const Rule& rule) : document_(document), rule_(rule) {}

  absl::Status Run() { return Walk(document_, rule_.path, ""); }

 private:
  // Follows the rest of the rule's path from `value`, which lies at `at`.
  absl::Status Walk(json& value, std::string_view rest, const std::string& at) {
    if (rest.empty()) return CheckValue(value, at);
    if (rest.starts_with("[]")) return WalkElements(value, rest.substr(2), at);
    if (rest.starts_with("{}")) return WalkValues(value, rest.substr(2), at);
    if (rest.starts_with('.')) rest.remove_prefix(1);
    if (!value.is_object()) return Wrong(value, at, "an object");
    const size_t end = std::min(rest.find_first_of(".[{"), rest.size());
    const std::string key(rest.substr(0, end));
    const std::string path = at.empty() ? key : absl::StrCat(at, ".", key);
    const auto child = value.find(key);
    if (child != value.end()) return Walk(*child, rest.substr(end), path);
    if (rule_.required && end == rest.size()) {
      return Malformed("SCHEMA", path, absl::StrCat("found nothing, need ", Need()));
    }
    return absl::OkStatus();
  }

  absl::Status WalkElements(json& value, std::string_view rest, const std::string& at) {
    if (!value.is_array()) return Wrong(value, at, "an array");
    for (size_t i = 0; i < value.size(); ++i) {
      absl::Status status = Walk(value[i], rest, absl::StrCat(at, "[", i, "]"));
      if (!status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status WalkValues(json& value, std::string_view rest, const std::string& at) {
    if (!value.is_object()) return Wrong(value, at, "an object");
    for (auto& [key, child] : value.items()) {
      absl::Status status = Walk(child, rest, absl::StrCat(at, "[", Quoted(key), "]"));
      if (!status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status CheckValue(json& value, const std::string& at) {
    return Holds(value) ? absl::OkStatus() : Wrong(value, at, Need());
  }

  bool Holds(json& value) const {
    switch (rule_.kind) {
      case Kind::kObject:
        return value.is_object();
      case Kind::kUnsigned:
        return IsUnsigned(value, rule_.min, rule_.max);
      case Kind::kIndex:
        return IsUnsigned(value, 0, static_cast<double>(TargetLength()) - 1.0);
      case Kind::kNumber:
        return value.is_number() && value.get<double>() >= rule_.min &&
               value.get<double>() <= rule_.max;
      case Kind::kNumbers:
        return value.is_array() && (rule_.count == 0 || value.size() == size_t(rule_.count)) &&
               std::all_of(value.begin(), value.end(), [](const json& v) { return v.is_number(); });
      case Kind::kBool:
        return value.is_boolean();
      case Kind::kString:
        return value.is_string() && (rule_.of.empty() || IsListed(value.get<std::string>()));
    }
    return false;
  }

  static bool IsUnsigned(json& value, double min, double max) {
    if (!value.is_number()) return false;
    const double number = value.get<double>();
    if (!(number >= min && number <= max && number <= 0x1p53) || number != std::floor(number)) {
      return false;
    }
    value = static_cast<uint64_t>(number);
    return true;
  }

  size_t TargetLength() const {
    const json* value = &document_;
    for (const absl::string_view key : absl::StrSplit(View(rule_.of), '.')) {
      const auto child = value->is_object() ? value->find(std::string(key)) : value->end();
      if (!value->is_object() || child == value->end()) return 0;
      value = &*child;
    }
    return value->is_array() ? value->size() : 0;
  }

  bool IsListed(const std::string& word) const {
    const std::vector<absl::string_view> words = absl::StrSplit(View(rule_.of), ' ');
    return std::find(words.begin(), words.end(), word) != words.end();
  }

  std::string Need() const {
    switch (rule_.kind) {
      case Kind::kObject:
        return "an object";
      case Kind::kUnsigned:
        return absl::StrCat("an integer >= ", rule_.min,
                            std::isfinite(rule_.max) ? absl::StrCat(" and <= ", rule_.max) : "");
      case Kind::kIndex:
        return absl::StrCat("an index < ", TargetLength(), ", the length of ", View(rule_.of));
      case Kind::kNumber:
        return absl::StrCat("a number >= ", rule_.min,
                            std::isfinite(rule_.max) ? absl::StrCat(" and <= ", rule_.max) : "");
      case Kind::kNumbers:
        return rule_.count == 0 ? "an array of numbers" : absl::StrCat(rule_.count, " numbers");
      case Kind::kBool:
        return "true or false";
      case Kind::kString:
        return rule_.of.empty() ? "a string" : absl::StrCat("one of ", View(rule_.of));
    }
    return "";
  }

  absl::Status Wrong(const json& value, const std::string& at, absl::string_view need) const {
    return Malformed("SCHEMA", at.empty() ? "document" : at,
                     absl::StrCat(Found(value), ", need ", need));
  }

  json& document_;
  const Rule& rule_;
};

}  // namespace

absl::Status CheckSchema(json& document, std::span<const Rule> rules) {
  for (const Rule& rule : rules) {
    absl::Status status = Checker(document, rule).Run();
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

JsonSize MeasureJson(std::string_view json) {
  JsonSize size;
  size_t depth = 0;
  bool in_string = false;
  for (size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      size.depth = std::max(size.depth, ++depth);
      ++size.values;
    } else if (c == ',') {
      ++size.values;
    } else if ((c == '}' || c == ']') && depth > 0) {
      --depth;
    }
  }
  return size;
}

}  // namespace penumbra::gltf
