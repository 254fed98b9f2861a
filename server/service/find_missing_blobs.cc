#include <set>
#include <string>

#include "proto/convert/geometry_convert.h"
#include "render/scene/field_error.h"
#include "server/service/penumbra_service.h"
#include "server/service/unary_call.h"

namespace penumbra {
namespace {

absl::StatusOr<v1::FindMissingBlobsResponse> FindMissing(
    const ServiceParts& parts, const Identity& identity,
    const v1::FindMissingBlobsRequest& request) {
  const ServerLimits& limits = parts.sessions.limits;
  if (static_cast<uint32_t>(request.hashes_size()) > limits.max_hashes_per_request) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_HASHES", "hashes",
                      "found " + std::to_string(request.hashes_size()) + ", need at most " +
                          std::to_string(limits.max_hashes_per_request));
  }
  v1::FindMissingBlobsResponse response;
  std::set<ContentHash> missing;
  for (int i = 0; i < request.hashes_size(); ++i) {
    const auto hash = HashFromProto(request.hashes(i), "hashes[" + std::to_string(i) + "]");
    if (!hash.ok()) return hash.status();
    const bool is_here =
        parts.sessions.blob_access.MaySee(identity, *hash) && parts.sessions.blobs.Contains(*hash);
    if (is_here) {
      parts.sessions.blob_access.Remember(identity, *hash);  // for the commit that follows
    } else if (missing.insert(*hash).second) {
      response.add_missing_hashes(request.hashes(i));
    }
  }
  return response;
}

}  // namespace

grpc::ServerUnaryReactor* PenumbraService::FindMissingBlobs(Context* context, const Bytes* request,
                                                            Bytes* response) {
  return AnswerUnary<v1::FindMissingBlobsRequest>(
      parts_, context, request, response,
      [&](const v1::FindMissingBlobsRequest& message, const Caller& caller) {
        return FindMissing(parts_, caller.identity(), message);
      });
}

}  // namespace penumbra
