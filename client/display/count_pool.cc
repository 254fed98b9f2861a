#include "client/display/count_pool.h"

#include <algorithm>
#include <span>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"

namespace penumbra {

void CountPool::Clear() {
  slots_.clear();
  buffer_ = gl::Buffer();
}

absl::Status CountPool::Update(gl::Context& context, const DrawList& list) {
  const size_t needed = std::max<size_t>(1, list.texel_count) * sizeof(uint16_t);
  if (needed > static_cast<size_t>(context.info().max_storage_bytes)) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "artifacts: found ", list.texel_count, " texels in all, need at most ",
        context.info().max_storage_bytes / sizeof(uint16_t), " to draw on this device"));
  }
  if (buffer_.size() < needed) {
    Clear();
    auto buffer = gl::Buffer::Create(context, (needed + 3) / 4 * 4);
    if (!buffer.ok()) return buffer.status();
    buffer_ = *std::move(buffer);
  }
  slots_.resize(list.receivers.size());
  for (size_t i = 0; i < slots_.size(); ++i) {
    Slot& slot = slots_[i];
    const uint32_t first = list.receivers[i].first_texel;
    if (slot.artifact == list.artifacts[i] && slot.first_texel == first) continue;
    slot = {.first_texel = first, .artifact = list.artifacts[i]};
    const auto& texture = std::get<SoftShadowTexture>(slot.artifact->payload);
    const absl::Status status = buffer_.Write(context, first * sizeof(uint16_t),
                                              std::as_bytes(std::span(texture.visibility.counts)));
    if (!status.ok()) return status;
    if (texture.coverage != nullptr) {
      const absl::Status masked =
          buffer_.Write(context, list.receivers[i].first_mask_word * sizeof(uint32_t),
                        std::as_bytes(texture.coverage->bytes()));
      if (!masked.ok()) return masked;
    }
    ++upload_count_;
  }
  return absl::OkStatus();
}

}  // namespace penumbra
