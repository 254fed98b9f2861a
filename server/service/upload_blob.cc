#include <memory>
#include <string>
#include <utility>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/status_convert.h"
#include "render/math/hand_over.h"
#include "render/scene/field_error.h"
#include "server/service/call_record.h"
#include "server/service/idle_timer.h"
#include "server/service/penumbra_service.h"
#include "server/service/refused_stream.h"
#include "server/session/bounded_parse.h"
#include "server/session/wire_message.h"

namespace penumbra {
namespace {

// Decoding and hashing more than this takes over a millisecond: too long for a gRPC thread.
constexpr uint64_t kLongBlobBytes = 512u << 10;

class UploadReactor final : public grpc::ServerReadReactor<grpc::ByteBuffer> {
 public:
  UploadReactor(const ServiceParts& parts, const Caller& caller,
                grpc::CallbackServerContext* context, grpc::ByteBuffer* response)
      : parts_(parts),
        identity_(caller.identity()),
        response_bytes_(response),
        timer_(IdleTimer::Start(context, parts.sessions.limits.transfer_idle_timeout)),
        right_(parts.guard.Follow(caller, nullptr, context)) {
    ReadNext();
  }

  void OnReadDone(bool ok) override {
    callbacks_.Take();
    timer_->Touch();
    if (!ok) return FinishCall();
    v1::UploadBlobRequest request;
    absl::Status status = ParseBounded(bytes_, parts_.sessions.limits, request);
    if (status.ok()) status = Take(request);
    if (!status.ok()) return Refuse(status);
    if (!upload_ || !upload_->is_complete()) return ReadNext();
    if (size_ > kLongBlobBytes || parts_.sessions.blobs.keeps_on_disk()) {
      parts_.transfers.uploads().Post(identity_.name, [this] { FinishBlob(); });
    } else {
      FinishBlob();
    }
  }

  void OnDone() override {
    callbacks_.Take();
    timer_->Stop();
    right_->Finish();
    delete this;
  }

 private:
  void ReadNext() {
    callbacks_.Give();
    StartRead(&bytes_);
  }

  absl::Status Take(const v1::UploadBlobRequest& request) {
    if (request.has_header()) {
      if (upload_) {
        return FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", "header",
                          "found a new blob, need the rest of the one before");
      }
      if (auto status = CheckCount(); !status.ok()) return status;
      const auto hash = HashFromProto(request.header().hash(), "header.hash");
      if (!hash.ok()) return hash.status();
      hash_ = *hash;
      size_ = request.header().size_bytes();
      const uint64_t quota = parts_.sessions.quotas.Of(identity_.name).blob_bytes;
      auto upload =
          parts_.sessions.blobs.Begin(hash_, size_, {.name = identity_.name, .max_bytes = quota});
      if (!upload.ok()) return upload.status();
      upload_ = *std::move(upload);
    }
    if (!upload_) {
      return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "header",
                        "found none, need one before a blob's bytes");
    }
    return upload_->Append(request.data());
  }

  // The response, which grows with each blob, has to fit into a message.
  absl::Status CheckCount() const {
    const uint32_t limit = parts_.sessions.limits.max_hashes_per_request;
    if (static_cast<uint32_t>(response_.blobs_size()) < limit) return absl::OkStatus();
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_HASHES", "header",
                      "found another blob after " + std::to_string(limit) + ", need at most " +
                          std::to_string(limit) + " in one call");
  }

  void FinishBlob() {
    const auto content = upload_->Finish();
    upload_.reset();
    if (!content.ok()) return Refuse(content.status());
    parts_.sessions.blob_access.Remember(identity_, hash_);
    v1::StoredBlob& stored = *response_.add_blobs();
    stored.set_hash(ToProto(hash_));
    stored.set_degenerate_triangle_count(DegenerateTriangleCount(*content));
    ReadNext();
  }

  // Gives the reservation back before the client can hear of the refusal.
  void Refuse(const absl::Status& status) {
    upload_.reset();
    record_.End(status);
    callbacks_.Give();
    Finish(ToGrpcStatus(status));
  }

  void FinishCall() {
    if (upload_) {
      return Refuse(FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", "data",
                               "found the end of the call, need the blob's rest"));
    }
    *response_bytes_ = ToBytes(response_);
    record_.End(absl::OkStatus());
    callbacks_.Give();
    Finish(grpc::Status::OK);
  }

  HandOver callbacks_;  // gRPC calls one after another, on any of its threads
  const ServiceParts& parts_;
  CallRecord record_{parts_.sessions.counters, parts_.logger, "UploadBlob"};
  const Identity identity_;
  grpc::ByteBuffer* const response_bytes_;
  const std::shared_ptr<IdleTimer> timer_;
  const std::shared_ptr<LiveCall> right_;
  grpc::ByteBuffer bytes_;
  v1::UploadBlobResponse response_;
  // The blob under way; its reservation ends with it.
  std::unique_ptr<BlobStore::Upload> upload_;
  ContentHash hash_;
  uint64_t size_ = 0;
};

}  // namespace

grpc::ServerReadReactor<grpc::ByteBuffer>* PenumbraService::UploadBlob(Context* context,
                                                                       Bytes* response) {
  const auto caller = parts_.guard.Admit(*context, "UploadBlob");
  if (!caller.ok()) return new RefusedStream<grpc::ServerReadReactor<Bytes>>(caller.status());
  return new UploadReactor(parts_, *caller, context, response);
}

}  // namespace penumbra
