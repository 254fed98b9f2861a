#include "server/option_sources.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"

namespace penumbra {
namespace {

constexpr size_t kMaxFileBytes = 1u << 20;
// What CLI11 takes for the beginning of a comment, also inside quotes; no file has it.
constexpr char kNoComment = '\x01';

std::string NameOf(const CLI::Option& option) { return option.get_single_name(); }

bool IsFlag(const CLI::Option& option) { return option.get_expected_min() == 0; }

bool IsList(const CLI::Option& option) { return option.get_items_expected_max() > 1; }

absl::Status FileError(const std::string& path, const std::string& text) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", text));
}

absl::StatusOr<std::string> Contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxFileBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.gcount() == 0 && !file.eof()) {
    return absl::NotFoundError(absl::StrCat("--config: found ", path, ", need a file to read"));
  }
  text.resize(static_cast<size_t>(file.gcount()));
  if (text.size() > kMaxFileBytes) return FileError(path, "found more than 1 MiB, need less");
  return text;
}

// `line` to its comment; none where a quote is left open.
std::optional<std::string> WithoutComment(const std::string& line) {
  char quote = '\0';
  for (size_t i = 0; i < line.size(); ++i) {
    if (quote != '\0') {
      if (line[i] == quote) quote = '\0';
    } else if (line[i] == '"' || line[i] == '\'') {
      quote = line[i];
    } else if (line[i] == '#') {
      return line.substr(0, i);
    }
  }
  if (quote != '\0') return std::nullopt;
  return line;
}

absl::StatusOr<std::vector<CLI::ConfigItem>> ItemsOf(const std::string& path) {
  const auto text = Contents(path);
  if (!text.ok()) return text.status();
  std::istringstream lines(*text);
  std::stringstream bare;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    const auto content = WithoutComment(line);
    const bool is_text = line.find('\0') == std::string::npos && !absl::StrContains(line, "\x01");
    if (!content || !is_text) {
      return FileError(path, absl::StrCat("line ", number, ": found ",
                                          content ? "a control character" : "a quote left open",
                                          ", need name = value"));
    }
    bare << *content << '\n';
  }
  CLI::ConfigTOML reader;
  reader.comment(kNoComment);
  try {
    return reader.from_config(bare);
  } catch (const CLI::ParseError& error) {
    return FileError(path, error.what());
  }
}

bool IsNumber(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, value);
  return parsed.ec == std::errc() && parsed.ptr == end;
}

// As the file has it; none where it cannot, for want of escapes.
std::optional<std::string> Literal(const std::string& text) {
  if (text == "true" || text == "false" || IsNumber(text)) return text;
  for (const char quote : {'"', '\''}) {
    if (text.find(quote) == std::string::npos)
      return absl::StrCat(std::string(1, quote), text, std::string(1, quote));
  }
  return std::nullopt;
}

std::optional<std::string> ValueOf(const CLI::Option& option) {
  std::vector<std::string> values{option.get_default_str()};
  if (option.count() > 0) {
    values = option.reduced_results();
  } else if (IsFlag(option)) {
    values = {"false"};
  } else if (IsList(option)) {
    values.clear();
  }
  std::vector<std::string> literals;
  for (const std::string& value : values) {
    auto literal = Literal(value);
    if (!literal || value.find('\n') != std::string::npos) return std::nullopt;
    literals.push_back(*std::move(literal));
  }
  const std::string joined = absl::StrJoin(literals, ", ");
  return IsList(option) ? absl::StrCat("[", joined, "]") : joined;
}

}  // namespace

std::string FromEnvironment(const std::string& name) {
  const char* value = std::getenv(name.c_str());
  return value ? value : "";
}

std::string EnvironmentName(const std::string& option) {
  return absl::StrCat("PENUMBRA_",
                      absl::AsciiStrToUpper(absl::StrReplaceAll(option, {{"-", "_"}})));
}

OptionSources::OptionSources(CLI::App& app)
    : options_(
          app.get_options([](const CLI::Option* option) { return option->get_configurable(); })) {
  for (const CLI::Option* option : options_) {
    if (option->count() > 0) sources_[option] = "command line";
  }
}

absl::Status OptionSources::Set(CLI::Option& option, const std::vector<std::string>& values,
                                const std::string& source) {
  sources_[&option] = source;
  try {
    if (IsFlag(option) && values.size() == 1) {
      option.add_result(option.get_flag_value(NameOf(option), values[0]));
    } else {
      option.add_result(values);
    }
    option.run_callback();
  } catch (const CLI::ParseError& error) {
    return absl::InvalidArgumentError(absl::StrCat(source, ": ", error.what()));
  }
  return absl::OkStatus();
}

absl::Status OptionSources::ReadEnvironment(const Environment& environment) {
  for (CLI::Option* option : options_) {
    const std::string name = EnvironmentName(NameOf(*option));
    const std::string value = environment(name);
    if (value.empty() || option->count() > 0) continue;
    if (auto status = Set(*option, {value}, name); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status OptionSources::ReadFile(const std::string& path) {
  const auto items = ItemsOf(path);
  if (!items.ok()) return items.status();
  std::set<std::string> seen;
  for (const CLI::ConfigItem& item : *items) {
    const auto named = std::find_if(options_.begin(), options_.end(), [&](const auto* option) {
      return NameOf(*option) == item.name;
    });
    if (!item.parents.empty() || named == options_.end()) {
      return FileError(path, absl::StrCat("found '", item.fullname(),
                                          "', need the name of an option without its --"));
    }
    if (!seen.insert(item.name).second) {
      return FileError(path, absl::StrCat("found '", item.name, "' twice, need it once"));
    }
    if ((*named)->count() > 0 || item.inputs.empty()) continue;
    if (auto status = Set(**named, item.inputs, path); !status.ok()) return status;
  }
  return absl::OkStatus();
}

std::string OptionSources::Print() const {
  std::string text;
  for (const CLI::Option* option : options_) {
    const auto source = sources_.find(option);
    const std::string from = source == sources_.end() ? "default" : source->second;
    if (const auto value = ValueOf(*option)) {
      absl::StrAppend(&text, NameOf(*option), " = ", *value, "  # ", from, "\n");
    } else {
      absl::StrAppend(&text, "# ", NameOf(*option), ", from ", from,
                      ", is a text that this form has no way to write\n");
    }
  }
  return text;
}

}  // namespace penumbra
