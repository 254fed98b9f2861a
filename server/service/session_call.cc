#include <grpc/grpc.h>

#include <memory>
#include <mutex>
#include <utility>

#include "proto/convert/status_convert.h"
#include "render/math/hand_over.h"
#include "server/service/call_record.h"
#include "server/service/penumbra_service.h"
#include "server/service/refused_stream.h"

namespace penumbra {
namespace {

class SessionReactor;

// Where whoever wakes a session finds its connection, for as long as there is one.
struct Gate {
  std::mutex mutex;
  SessionReactor* reactor = nullptr;
};

// Carries a session's bytes: one read and one write at a time.
class SessionReactor final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  SessionReactor(const ServiceParts& parts, const Caller& caller,
                 grpc::CallbackServerContext* context)
      : record_(parts.sessions.counters, parts.logger, "Session"),
        context_(*context),
        gate_(std::make_shared<Gate>()) {
    gate_->reactor = this;
    session_ = Session::Create(
        parts.sessions, caller,
        [gate = gate_] {
          std::lock_guard lock(gate->mutex);
          if (gate->reactor) gate->reactor->Pump();
        },
        [gate = gate_](const absl::Status& reason) {
          std::lock_guard lock(gate->mutex);
          if (gate->reactor) gate->reactor->LetGo(reason);
        });
    right_ = parts.guard.Follow(
        caller,
        [weak = std::weak_ptr(session_)](const absl::Status& status) {
          if (const auto session = weak.lock()) session->End(status);
        },
        context);
    const absl::Status added = parts.session_table.Add(session_, caller.identity().name);
    if (!added.ok()) session_->End(added);
    std::lock_guard lock(gate_->mutex);
    Pump();
  }

  void OnReadDone(bool ok) override {
    callbacks_.Take();
    if (!ok) return session_->End(absl::OkStatus());
    session_->OnRequest(request_);
    std::lock_guard lock(gate_->mutex);
    is_read_due_ = true;
    Pump();
  }

  void OnWriteDone(bool ok) override {
    callbacks_.Take();
    if (!ok) session_->End(absl::CancelledError("the connection is gone"));
    session_->OnSent();
    std::lock_guard lock(gate_->mutex);
    is_writing_ = false;
    Pump();
  }

  void OnCancel() override {
    callbacks_.Take();
    session_->End(absl::CancelledError("the call was cancelled"));
    callbacks_.Give();
  }

  void OnDone() override {
    callbacks_.Take();
    {
      std::lock_guard lock(gate_->mutex);
      gate_->reactor = nullptr;
    }
    right_->Finish();
    session_->Close();
    delete this;
  }

 private:
  // With the gate locked, as for all below.
  void Pump() {
    if (!is_writing_ && !is_finished_) WriteNext();
    if (is_read_due_ && !is_finished_ && session_->has_room()) {
      is_read_due_ = false;
      callbacks_.Give();
      StartRead(&request_);
    }
    callbacks_.Give();
  }

  // An end that the client's not reading does not hold up: it goes past what waits to be read.
  void LetGo(const absl::Status& reason) {
    grpc_call_cancel_with_status(context_.c_call(), static_cast<grpc_status_code>(reason.code()),
                                 MessageWithReason(reason).c_str(), nullptr);
  }

  void WriteNext() {
    auto output = session_->Next();
    if (output.message) {
      is_writing_ = true;
      response_ = *std::move(output.message);
      session_->record().CountSent(response_.Length());
      callbacks_.Give();
      StartWrite(&response_);
    } else if (output.end) {
      is_finished_ = true;
      record_.End(*output.end);
      callbacks_.Give();
      Finish(ToGrpcStatus(*output.end));
    }
  }

  CallRecord record_;
  HandOver callbacks_;  // gRPC calls one after another, on any of its threads
  grpc::CallbackServerContext& context_;
  const std::shared_ptr<Gate> gate_;
  std::shared_ptr<Session> session_;
  std::shared_ptr<LiveCall> right_;
  grpc::ByteBuffer request_;
  grpc::ByteBuffer response_;
  bool is_writing_ = false;
  bool is_finished_ = false;
  bool is_read_due_ = true;
};

}  // namespace

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* PenumbraService::Session(
    Context* context) {
  const auto caller = parts_.guard.Admit(*context, "Session");
  if (!caller.ok()) {
    return new RefusedStream<grpc::ServerBidiReactor<Bytes, Bytes>>(caller.status());
  }
  return new SessionReactor(parts_, *caller, context);
}

}  // namespace penumbra
