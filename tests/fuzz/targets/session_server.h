// All that sessions work with, without connections, a disk, or threads that compute.
//
//   SessionServer server(limits);         // once: it takes threads and a connection to itself
//   server.MakeScene();                   // for each script
//   auto session = server.Open();
//   …
//   server.DropScene();                   // while sessions are open, or later
#pragma once

#include <memory>
#include <string>

#include "server/log/logger.h"
#include "server/security/server_security.h"
#include "server/session/session.h"
#include "tests/fuzz/targets/prompt_engine.h"

namespace penumbra::fuzzing {

class SessionServer {
 public:
  explicit SessionServer(const ServerLimits& limits);

  // The scene "studio", with the small studio in it, at revision 1.
  void MakeScene();
  void DropScene();

  // Of the one principal of a server that asks nobody who they are.
  std::shared_ptr<Session> Open();

  // After a commit: whoever follows artifacts has the new ones at once.
  void TellOfCommit(const Scene& scene) { artifacts_.Tell(scene); }

  const ServerLimits& limits() const { return limits_; }
  std::shared_ptr<const Scene> Newest() { return scenes_.Snapshot("studio").value(); }
  const std::string& incarnation() const { return incarnation_; }
  const PresenceRoom& room() const { return *room_; }
  // The participant who edits where only one may; empty: nobody.
  std::string Editor() const;

  // Ends the process where sessions that were closed have left something.
  void RequireNothingOpen() const;

 private:
  const ServerLimits limits_;
  const std::unique_ptr<ServerSecurity> security_ = ServerSecurity::Create({}).value();
  const Caller caller_;
  PrincipalQuotas quotas_{QuotaOptions{}};
  ServerCounters counters_;
  SessionLedger ledger_{counters_, QuietLogger()};
  StreamServices stream_services_{counters_};
  LocalEngine engine_;
  BlobStore blobs_{limits_};
  BlobAccess blob_access_{engine_};
  SceneStore scenes_{engine_, blobs_, limits_, counters_, nullptr};
  PromptEngine artifacts_{engine_};
  StreamTable streams_{artifacts_, stream_services_};
  SceneUpdates updates_{limits_.max_message_bytes};
  ProcessorAdmission processor_{limits_};
  // Its thread may be the last to let go of a session.
  PresenceTable presence_;
  const SessionServices services_{.scenes = scenes_,
                                  .blobs = blobs_,
                                  .blob_access = blob_access_,
                                  .streams = streams_,
                                  .presence = presence_,
                                  .updates = updates_,
                                  .quotas = quotas_,
                                  .processor = processor_,
                                  .limits = limits_,
                                  .counters = counters_,
                                  .ledger = ledger_};
  // Of the scene.
  std::string incarnation_;
  std::shared_ptr<PresenceRoom> room_;
};

}  // namespace penumbra::fuzzing
