#include "render/light_view/gl/mesh_store.h"

#include <algorithm>
#include <memory>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {

void GpuMesh::Bind(gl::Context& context) const {
  positions.BindStorage(context, kPositionsBinding);
  indices.BindStorage(context, kIndicesBinding);
  uvs.BindStorage(context, kUvsBinding);
}

MeshStore& MeshStore::Of(gl::Context& context) {
  static constexpr char kOwner = 0;
  std::shared_ptr<void>& kept = context.Kept(&kOwner);
  if (!kept) {
    kept = std::make_shared<MeshStore>(std::min(kMaxKeptBytes, context.memory().limit() / 2));
  }
  return *static_cast<MeshStore*>(kept.get());
}

MeshStore::Entry* MeshStore::Find(const ContentHash& id) {
  const auto found = by_id_.find(id);
  if (found == by_id_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, found->second);
  return &entries_.front();
}

absl::Status MeshStore::MakeRoom(size_t bytes, size_t limit, const ContentHash* pinned,
                                 const char* what, std::string_view field) {
  if (pinned) limit = std::min(limit, max_bytes_ - entries_.front().bytes);
  if (bytes > std::min(limit, max_bytes_)) {
    return FieldError(absl::StatusCode::kResourceExhausted, "GL_MEMORY", field,
                      absl::StrCat("found gl and ", what, " of ", bytes, " bytes, need at most ",
                                   std::min(limit, max_bytes_), " or another method"));
  }
  while (bytes_ + bytes > max_bytes_) {
    bytes_ -= entries_.back().bytes;
    by_id_.erase(entries_.back().id);
    entries_.pop_back();
  }
  return absl::OkStatus();
}

MeshStore::Entry& MeshStore::Add(Entry entry) {
  bytes_ += entry.bytes;
  ++upload_count_;
  entries_.push_front(std::move(entry));
  by_id_[entries_.front().id] = entries_.begin();
  return entries_.front();
}

absl::StatusOr<const GpuMesh*> MeshStore::Mesh(gl::Context& context, const penumbra::Mesh& mesh,
                                               std::string_view field) {
  if (Entry* entry = Find(mesh.id())) return &std::get<GpuMesh>(entry->content);
  const size_t bytes =
      mesh.positions().size_bytes() + mesh.indices().size_bytes() + mesh.uvs().size_bytes();
  const auto limit = static_cast<size_t>(context.info().max_storage_bytes);
  if (absl::Status status = MakeRoom(bytes, limit, nullptr, "a mesh", field); !status.ok()) {
    return status;
  }
  auto positions = gl::Buffer::Create(context, std::as_bytes(mesh.positions()));
  if (!positions.ok()) return positions.status();
  auto indices = gl::Buffer::Create(context, std::as_bytes(mesh.indices()));
  if (!indices.ok()) return indices.status();
  auto uvs = gl::Buffer::Create(context, std::as_bytes(mesh.uvs()));
  if (!uvs.ok()) return uvs.status();
  Entry& entry =
      Add({mesh.id(), bytes, GpuMesh{*std::move(positions), *std::move(indices), *std::move(uvs)}});
  return &std::get<GpuMesh>(entry.content);
}

absl::StatusOr<const gl::Texture*> MeshStore::Mask(gl::Context& context, const AlphaMask& mask,
                                                   const penumbra::Mesh& beside,
                                                   std::string_view field) {
  if (Entry* entry = Find(mask.id())) return &std::get<gl::Texture>(entry->content);
  const size_t bytes = mask.alpha().size();
  absl::Status room = MakeRoom(bytes, max_bytes_, &beside.id(), "an alpha mask", field);
  if (!room.ok()) return room;
  auto texture = gl::Texture::Create(context, {.width = static_cast<int>(mask.width()),
                                               .height = static_cast<int>(mask.height()),
                                               .format = gl::Format::kR8Ui});
  if (!texture.ok()) return texture.status();
  absl::Status status = texture->Write(context, std::as_bytes(mask.alpha()));
  if (!status.ok()) return status;
  return &std::get<gl::Texture>(Add({mask.id(), bytes, *std::move(texture)}).content);
}

int LeastAlpha(float cutoff) {
  int least = 0;
  while (least < 256 && !(static_cast<float>(least) / 255.0f >= cutoff)) ++least;
  return least;
}

}  // namespace penumbra
