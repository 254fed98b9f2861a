#include "client/session/archive_transfer.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include "client/session/blob_transfer.h"
#include "client/session/call_status.h"
#include "client/session/message_room.h"
#include "client/session/server_connection.h"
#include "proto/archive/archive_file_reader.h"
#include "proto/archive/archive_file_writer.h"
#include "proto/archive/archive_order.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Of the bytes of a delta in one message at most, which leaves room for the rest.
constexpr size_t kChunkBytes = 256u << 10;
// Blobs that have just been uploaded may go before the scene is there that names them, on a server
// that is full.
constexpr int kTries = 3;
// A scene's history takes the server some time to look through.
constexpr uint64_t kExportBytes = uint64_t{1} << 30;

// Ends a call when a stop is asked for.
class StopsCall {
 public:
  StopsCall(const std::stop_token& stop, grpc::ClientContext& context)
      : callback_(stop, [&context] { context.TryCancel(); }) {}

 private:
  std::stop_callback<std::function<void()>> callback_;
};

// One call that uploads blobs, of which a server takes so many; cancelled unless it is finished.
class UploadCall {
 public:
  UploadCall(ServerConnection& connection, const std::stop_token& stop, uint64_t bytes)
      : connection_(connection), on_stop_(stop, context_) {
    connection.Prepare(context_, bytes);
    writer_ = connection.stub().UploadBlob(&context_, &response_);
  }
  ~UploadCall() {
    if (!writer_) return;
    context_.TryCancel();
    Finish().IgnoreError();
  }

  size_t blobs() const { return blobs_; }

  // What a record has of a blob's bytes. False: the call has ended.
  bool Write(const v1::ArchiveRecord& record, size_t chunk_bytes) {
    v1::UploadBlobRequest request;
    if (record.has_blob()) {
      request.mutable_header()->set_hash(record.blob().hash());
      request.mutable_header()->set_size_bytes(record.blob().size_bytes());
      ++blobs_;
    }
    const std::string& data = record.data();
    for (size_t at = 0; at < data.size(); at += chunk_bytes) {
      request.set_data(data.substr(at, chunk_bytes));
      if (!writer_->Write(request)) return false;
      request.clear_header();
    }
    return true;
  }

  absl::Status Finish() {
    const auto writer = std::exchange(writer_, nullptr);
    writer->WritesDone();
    return StatusOfCall(connection_.options().address, writer->Finish());
  }

 private:
  ServerConnection& connection_;
  size_t blobs_ = 0;
  grpc::ClientContext context_;
  const StopsCall on_stop_;
  v1::UploadBlobResponse response_;
  std::unique_ptr<grpc::ClientWriter<v1::UploadBlobRequest>> writer_;
};

// Collects records into messages as an import takes them, without the bytes of blobs and in pieces
// that fit, and writes those that are full.
class RecordStream {
 public:
  RecordStream(grpc::ClientWriter<v1::ImportSceneRequest>& writer, const std::string& scene_id,
               size_t max_bytes)
      : writer_(writer),
        max_bytes_(RoomInMessage(max_bytes)),
        chunk_bytes_(std::min(kChunkBytes, max_bytes_ / 2)) {
    message_.set_scene_id(scene_id);
  }

  // False: the call has ended.
  bool Add(v1::ArchiveRecord record) {
    const bool begins = record.begins_case() != v1::ArchiveRecord::BEGINS_NOT_SET;
    if (begins) is_in_blob_ = record.has_blob();
    if (is_in_blob_ && !begins) return true;
    std::string data;
    data.swap(*record.mutable_data());
    if (is_in_blob_) data.clear();
    size_t at = 0;
    do {
      record.set_data(data.substr(at, chunk_bytes_));
      if (!AddPiece(record)) return false;
      record.Clear();
      at += chunk_bytes_;
    } while (at < data.size());
    return true;
  }
  bool Flush() {
    const bool is_open = writer_.Write(message_);
    message_.Clear();
    bytes_ = 0;
    return is_open;
  }

 private:
  bool AddPiece(const v1::ArchiveRecord& record) {
    constexpr size_t kFraming = 8;
    const size_t size = record.ByteSizeLong() + kFraming;
    if (bytes_ + size > max_bytes_ && message_.records_size() > 0 && !Flush()) return false;
    bytes_ += size;
    *message_.add_records() = record;
    return true;
  }

  grpc::ClientWriter<v1::ImportSceneRequest>& writer_;
  const size_t max_bytes_;
  const size_t chunk_bytes_;
  v1::ImportSceneRequest message_;
  size_t bytes_ = 0;
  bool is_in_blob_ = false;
};

}  // namespace

// Who has asked for a stop is told so, wherever it came.
absl::Status ArchiveTransfer::EndOf(const std::filesystem::path& file,
                                    const absl::Status& status) const {
  if (!absl::IsCancelled(status) || !options_.stop.stop_requested()) return status;
  return absl::CancelledError(file.string() + ": stopped");
}

void ArchiveTransfer::Show(uint64_t moved, uint64_t total) const {
  if (options_.progress) options_.progress(moved, total);
}

absl::Status ArchiveTransfer::Export(const std::string& scene_id,
                                     const std::filesystem::path& file) {
  const auto writer = ArchiveFileWriter::Create(file);
  if (!writer.ok()) return writer.status();
  grpc::ClientContext context;
  const StopsCall on_stop(options_.stop, context);
  connection_.Prepare(context, kExportBytes);
  v1::ExportSceneRequest request;
  request.set_scene_id(scene_id);
  request.set_without_history(!options_.with_history);
  const auto reader = connection_.stub().ExportScene(&context, request);
  ArchiveOrder order({});
  v1::ExportSceneResponse response;
  absl::Status status;
  while (status.ok() && reader->Read(&response)) {
    for (const v1::ArchiveRecord& record : response.records()) {
      if (status.ok()) status = order.Take(record).status();
      if (status.ok()) status = (*writer)->Write(record);
    }
    Show((*writer)->size_bytes(), 0);
  }
  if (!status.ok()) context.TryCancel();
  const absl::Status ended =
      EndOf(file, StatusOfCall(connection_.options().address, reader->Finish()));
  if (!status.ok()) return status;
  if (!ended.ok()) return ended;
  if (!order.has_ended()) return absl::DataLossError("found no end of the archive, need all of it");
  return (*writer)->Finish();
}

absl::StatusOr<SceneInfo> ArchiveTransfer::Import(const std::filesystem::path& file,
                                                  const std::string& scene_id) {
  // All of it, before anything is sent.
  const auto info = ReadArchive(file, {.stop = options_.stop});
  if (!info.ok()) return info.status();
  const std::string& id = scene_id.empty() ? info->scene_id : scene_id;
  std::vector<ContentHash> hashes;
  for (const ArchivedBlobName& blob : info->blobs) hashes.push_back(blob.hash);
  absl::StatusOr<SceneInfo> imported;
  for (int i = 0; i < kTries; ++i) {
    const auto missing = connection_.blobs().FindMissing(hashes);
    if (!missing.ok()) return missing.status();
    if (!missing->empty()) {
      if (auto status = Upload(file, *missing, info->file_bytes); !status.ok()) return status;
    }
    imported = Send(file, id, info->file_bytes);
    if (ErrorReason(imported.status()) != "MISSING_BLOB") break;
  }
  return imported;
}

absl::Status ArchiveTransfer::Upload(const std::filesystem::path& file,
                                     const std::vector<ContentHash>& missing, uint64_t bytes) {
  const auto reader = ArchiveFileReader::Open(file);
  if (!reader.ok()) return reader.status();
  std::set<std::string> wanted;
  for (const ContentHash& hash : missing) wanted.insert(ToProto(hash));
  BlobTransfer& limits = connection_.blobs();
  std::unique_ptr<UploadCall> call;
  bool is_wanted = false;
  for (bool is_open = true; is_open;) {
    const auto record = (*reader)->Next();
    if (!record.ok()) return record.status();
    // Blobs come before the rest.
    if (!*record || (*record)->has_commit() || (*record)->has_base()) break;
    if ((*record)->has_blob()) {
      is_wanted = wanted.contains((*record)->blob().hash());
      if (is_wanted && call && call->blobs() == limits.blobs_per_call()) {
        if (auto status = EndOf(file, call->Finish()); !status.ok()) return status;
        call.reset();
      }
      if (is_wanted && !call)
        call = std::make_unique<UploadCall>(connection_, options_.stop, bytes);
    }
    if (is_wanted) is_open = call->Write(**record, limits.chunk_bytes());
    Show((*reader)->read_bytes(), bytes);
  }
  return call ? EndOf(file, call->Finish()) : absl::OkStatus();
}

absl::StatusOr<SceneInfo> ArchiveTransfer::Send(const std::filesystem::path& file,
                                                const std::string& scene_id, uint64_t bytes) {
  const auto reader = ArchiveFileReader::Open(file);
  if (!reader.ok()) return reader.status();
  grpc::ClientContext context;
  const StopsCall on_stop(options_.stop, context);
  connection_.Prepare(context, bytes);
  v1::ImportSceneResponse response;
  const auto writer = connection_.stub().ImportScene(&context, &response);
  RecordStream stream(*writer, scene_id, connection_.max_message_bytes());
  absl::Status status;
  for (bool is_open = true; is_open && status.ok();) {
    auto record = (*reader)->Next();
    status = record.status();
    if (!status.ok()) break;
    if (!*record) {
      stream.Flush();
      break;
    }
    is_open = stream.Add(**std::move(record));
    Show((*reader)->read_bytes(), bytes);
  }
  if (!status.ok()) context.TryCancel();
  writer->WritesDone();
  const absl::Status ended =
      EndOf(file, StatusOfCall(connection_.options().address, writer->Finish()));
  if (!status.ok()) return status;
  if (!ended.ok()) return ended;
  return FromProto(response.scene());
}

}  // namespace penumbra
