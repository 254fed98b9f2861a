// What sessions work with.
#pragma once

#include "server/counters.h"
#include "server/limits.h"
#include "server/processor_admission.h"
#include "server/quota/principal_quotas.h"
#include "server/scene_store/blob_store.h"
#include "server/scene_store/scene_store.h"
#include "server/security/blob_access.h"
#include "server/session/artifact_stream.h"
#include "server/session/presence.h"
#include "server/session/scene_updates.h"
#include "server/session/session_ledger.h"

namespace penumbra {

// All of it outlives them.
struct SessionServices {
  SceneStore& scenes;
  BlobStore& blobs;
  BlobAccess& blob_access;
  StreamTable& streams;
  PresenceTable& presence;
  SceneUpdates& updates;
  PrincipalQuotas& quotas;
  ProcessorAdmission& processor;
  const ServerLimits& limits;
  ServerCounters& counters;
  SessionLedger& ledger;
};

}  // namespace penumbra
