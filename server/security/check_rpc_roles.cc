// Run by the build: whether the table of roles has a row for every call of the service and for
// every kind of request in a session, and none besides. `--markdown` prints the table of
// docs/security.md.

#include <cstdio>
#include <cstring>
#include <set>
#include <string>

#include "penumbra/v1/service.pb.h"
#include "penumbra/v1/session.pb.h"
#include "server/security/rpc_roles.h"

namespace penumbra {
namespace {

std::set<std::string> NamesInProtocol() {
  std::set<std::string> names;
  const auto* service = v1::CreateSceneRequest::descriptor()->file()->service(0);
  for (int i = 0; i < service->method_count(); ++i) names.insert(service->method(i)->name());
  const auto* requests = v1::SessionRequest::descriptor()->FindOneofByName("request");
  for (int i = 0; i < requests->field_count(); ++i) {
    names.insert("Session." + requests->field(i)->name());
  }
  return names;
}

int Check() {
  std::set<std::string> unseen = NamesInProtocol();
  int faults = 0;
  for (const RpcRole& row : RpcRoles()) {
    if (unseen.erase(std::string(row.name)) == 1) continue;
    std::fprintf(stderr, "server/security/rpc_roles.cc: %s is no call, or has two rows\n",
                 std::string(row.name).c_str());
    ++faults;
  }
  for (const std::string& name : unseen) {
    std::fprintf(stderr, "server/security/rpc_roles.cc: %s has no row: who may call it?\n",
                 name.c_str());
    ++faults;
  }
  return faults == 0 ? 0 : 1;
}

const char* RuleText(SceneRule rule) {
  switch (rule) {
    case SceneRule::kNone:
      return "";
    case SceneRule::kNamed:
      return "out of scope: `NOT_FOUND`";
    case SceneRule::kMade:
      return "out of scope: `PERMISSION_DENIED`";
    case SceneRule::kListed:
      return "those in scope";
    case SceneRule::kContents:
      return "blobs of scenes in scope, and own uploads";
  }
  return "";
}

void PrintMarkdown() {
  std::printf("| call | least role | scenes | note |\n| --- | --- | --- | --- |\n");
  for (const RpcRole& row : RpcRoles()) {
    std::printf("| `%s` | %s | %s | %s |\n", std::string(row.name).c_str(),
                std::string(RoleName(row.least)).c_str(), RuleText(row.scene),
                std::string(row.why).c_str());
  }
}

}  // namespace
}  // namespace penumbra

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--markdown") == 0) {
    penumbra::PrintMarkdown();
    return 0;
  }
  return penumbra::Check();
}
