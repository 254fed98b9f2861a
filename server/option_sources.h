// Gives options that the command line leaves open their values from other places, in the order in
// which these are read, and remembers where each came from.
//
//   app.parse(…);
//   OptionSources sources(app);
//   sources.ReadEnvironment(FromEnvironment);   // PENUMBRA_DRAIN_SECONDS for --drain-seconds
//   sources.ReadFile("/etc/penumbra.toml");     // drain-seconds = 5
//   std::string text = sources.Print();         // such a file, with the values in effect
//
// CLI11 can do both itself, but lets the file go before the environment, and does not say which of
// them a bad value came from.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace penumbra {

// The value of a variable; empty where it is not set, or set to nothing.
using Environment = std::function<std::string(const std::string& name)>;

// This process's.
std::string FromEnvironment(const std::string& name);

// The variable of an option: "PENUMBRA_LOG_LEVEL" for "log-level".
std::string EnvironmentName(const std::string& option);

class OptionSources {
 public:
  // `app` has parsed the command line, and outlives this. Options that are not configurable()
  // are left out.
  explicit OptionSources(CLI::App& app);

  // Errors  kInvalidArgument: the variable, the option, and what is wrong with the value
  absl::Status ReadEnvironment(const Environment& environment);

  // TOML as CLI11 reads it: lines of `name = value`, numbers, true and false, texts in quotes
  // without escapes, lists in brackets, comments. An option that the environment has too may stand
  // there.
  //
  // Errors  kNotFound: the file; kInvalidArgument: the file, and the line, name or value in it that
  //         is wrong
  absl::Status ReadFile(const std::string& path);

  // Every option's value as a line for ReadFile, with its source as a comment. No option's value is
  // a secret: secrets stand in files that options name.
  std::string Print() const;

 private:
  absl::Status Set(CLI::Option& option, const std::vector<std::string>& values,
                   const std::string& source);

  const std::vector<CLI::Option*> options_;
  std::map<const CLI::Option*, std::string> sources_;  // of those that have one
};

}  // namespace penumbra
