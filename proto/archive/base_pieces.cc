#include "proto/archive/base_pieces.h"

#include <utility>

namespace penumbra {
namespace {

constexpr size_t kFieldOverhead = 8;  // tag and length

class Pieces {
 public:
  explicit Pieces(size_t max_bytes) : max_bytes_(max_bytes), pieces_(1) {}

  v1::SceneDelta& For(size_t bytes) {
    if (used_ > 0 && used_ + bytes + kFieldOverhead > max_bytes_) {
      pieces_.back().set_is_continued(true);
      pieces_.emplace_back();
      used_ = 0;
    }
    used_ += bytes + kFieldOverhead;
    return *pieces_.back().mutable_delta();
  }
  std::vector<v1::ArchiveBase> Take() { return std::move(pieces_); }

 private:
  const size_t max_bytes_;
  size_t used_ = 0;
  std::vector<v1::ArchiveBase> pieces_;
};

}  // namespace

std::vector<v1::ArchiveBase> BasePieces(v1::SceneDelta whole, size_t max_bytes) {
  Pieces pieces(max_bytes);
  for (v1::Instance& instance : *whole.mutable_upsert_instances()) {
    *pieces.For(instance.ByteSizeLong()).add_upsert_instances() = std::move(instance);
  }
  for (v1::Light& light : *whole.mutable_upsert_lights()) {
    *pieces.For(light.ByteSizeLong()).add_upsert_lights() = std::move(light);
  }
  for (v1::Receiver& receiver : *whole.mutable_upsert_receivers()) {
    *pieces.For(receiver.ByteSizeLong()).add_upsert_receivers() = std::move(receiver);
  }
  return pieces.Take();
}

}  // namespace penumbra
