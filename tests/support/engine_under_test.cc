#include "tests/support/engine_under_test.h"

#include <utility>

#include "client/session/remote_engine.h"
#include "render/engine/local_engine.h"
#include "server/penumbra_server.h"

namespace penumbra::testing {
namespace {

// A server of its own on any free port, and a client of it.
struct Loopback {
  std::unique_ptr<PenumbraServer> server;
  std::unique_ptr<RemoteEngine> client;

  ~Loopback() {
    client.reset();
    server.reset();
  }
};

std::shared_ptr<Engine> MakeRemote() {
  auto loopback = std::make_shared<Loopback>();
  loopback->server = PenumbraServer::Start({.listen = "127.0.0.1:0", .opens_gl = false}).value();
  loopback->client = RemoteEngine::Connect({.address = loopback->server->address()}).value();
  Engine* const engine = loopback->client.get();
  return std::shared_ptr<Engine>(std::move(loopback), engine);
}

}  // namespace

std::vector<EngineUnderTest> EnginesUnderTest() {
  return {{"Local", [] { return std::make_shared<LocalEngine>(); }}, {"Remote", MakeRemote}};
}

}  // namespace penumbra::testing
