#include "server/security/token_command.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"
#include "server/security/bearer_token.h"
#include "server/security/identity_file.h"
#include "server/security/role.h"
#include "server/security/scene_scope.h"
#include "server/security/split.h"

namespace penumbra {
namespace {

std::string LineOf(const TokenRequest& request, const std::string& token) {
  std::string line = absl::StrCat("token sha256:", HashOfToken(token).hex(), " ", request.name, " ",
                                  request.role, " ", request.scenes);
  if (request.days > 0) {
    const absl::Time expires = absl::Now() + absl::Hours(24) * request.days;
    absl::StrAppend(&line, " ",
                    absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", expires, absl::UTCTimeZone()));
  }
  return line;
}

// Whether a line that is added to the file would go on in its last one.
bool LacksLineEnd(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file || file.tellg() <= 0) return false;
  file.seekg(-1, std::ios::end);
  return file.get() != '\n';
}

// By the options' names, where the file's reader would speak of a line of it.
absl::Status Check(const TokenRequest& request) {
  if (auto status = CheckId(request.name, "--name"); !status.ok()) return status;
  if (!RoleNamed(request.role)) {
    return FieldError(absl::StatusCode::kInvalidArgument, "BAD_IDENTITY", "--role",
                      absl::StrCat("found '", request.role, "', need viewer, editor or admin"));
  }
  const auto patterns = Split(request.scenes, ",");
  const auto scope = SceneScope::Create({patterns.begin(), patterns.end()});
  return scope.ok() ? absl::OkStatus() : WithFieldPrefix(scope.status(), "--");
}

void Make(const TokenRequest& request) {
  if (auto status = Check(request); !status.ok()) {
    throw CLI::ValidationError(std::string(status.message()));
  }
  const std::string token = MakeBearerToken();
  const std::string line = LineOf(request, token);
  const auto parsed = IdentityFile::Parse(line);
  if (!parsed.ok()) throw CLI::ValidationError(std::string(parsed.status().message()));
  if (request.append.empty()) {
    std::fprintf(stderr, "for the file of --tokens:\n%s\n", line.c_str());
  } else {
    const char* const start = LacksLineEnd(request.append) ? "\n" : "";
    std::ofstream out(request.append, std::ios::app);
    out << start << line << std::endl;
    if (!out) throw CLI::FileError("--append: cannot write " + request.append);
  }
  std::printf("%s\n", token.c_str());
  throw CLI::Success();
}

}  // namespace

void AddTokenCommand(CLI::App& app, TokenRequest& request) {
  CLI::App* command = app.add_subcommand(
      "token",
      "Make a bearer token. It is printed once and kept nowhere; the file of --tokens gets a line "
      "with its SHA-256: token HASH NAME ROLE SCENES [TIME]");
  command->add_option("--name", request.name, "Whose it is")->required();
  command->add_option("--role", request.role, "viewer, editor or admin")->required();
  command->add_option("--scenes", request.scenes, "Patterns of ids such as review-*,studio")
      ->capture_default_str();
  command->add_option("--days", request.days, "How long it is valid; 0: for good")
      ->check(CLI::Range(0, 36'500))
      ->capture_default_str();
  command->add_option("--append", request.append, "Add the line to this file");
  command->final_callback([&request] { Make(request); });
}

}  // namespace penumbra
