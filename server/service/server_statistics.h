// The counters as GetServerInfo and GetServerStatus tell them.
#pragma once

#include "penumbra/v1/server_info.pb.h"
#include "server/service/penumbra_service.h"

namespace penumbra {

v1::ServerStatistics StatisticsOf(const ServiceParts& parts);

// Milliseconds since the server's start.
uint64_t UptimeMs(const ServiceParts& parts);

}  // namespace penumbra
