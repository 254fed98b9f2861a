#include "client/display/word_pool.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>
#include <variant>

#include "absl/strings/str_format.h"
#include "client/display/surface_glsl.h"

namespace penumbra {
namespace {

bool IsPictureOf(const Artifact& artifact, const Camera& camera) {
  const auto* view = std::get_if<ViewShadow>(&artifact.payload);
  const auto* picture = view ? std::get_if<PicturePixels>(&view->points) : nullptr;
  return picture != nullptr && picture->camera == camera;
}

template <typename T>
absl::StatusOr<gl::Buffer> BufferOf(gl::Context& context, std::vector<T> values) {
  if (values.empty()) values.emplace_back();  // no buffer is empty
  return gl::Buffer::Create(context, std::as_bytes(std::span(values)));
}

}  // namespace

void WordPool::Clear() {
  uploaded_.clear();
  for (gl::Buffer* buffer : {&shadows_, &faces_, &words_}) *buffer = gl::Buffer();
}

// Of each light and kind the last one.
WordPool::Chosen WordPool::Choose(const DrawList& list, const Camera& camera) {
  std::map<std::pair<uint32_t, size_t>, std::shared_ptr<const Artifact>> last;
  for (const auto& [light, artifact] : list.of_any_surface) {
    const bool is_for_any_view = std::holds_alternative<AttenuationLdi>(artifact->payload) ||
                                 std::holds_alternative<ShadowWidthMap>(artifact->payload);
    if (!is_for_any_view && !IsPictureOf(*artifact, camera)) continue;
    last[{light, artifact->payload.index()}] = artifact;
  }
  Chosen chosen;
  for (const auto& [key, artifact] : last) chosen.emplace_back(key.first, artifact);
  return chosen;
}

absl::Status WordPool::Update(gl::Context& context, const DrawList& list, const Camera& camera,
                              const std::vector<uint32_t>& order) {
  Chosen now = Choose(list, camera);
  if (shadows_.size() > 0 && now == uploaded_ && order == order_) return absl::OkStatus();
  ShadowWords words;
  std::vector<LightShadow> shadows(list.lights.size());
  for (size_t place = 0; place < order.size(); ++place) shadows[place].drawn_light = order[place];
  for (const auto& [light, artifact] : now) {
    if (const auto* ldi = std::get_if<AttenuationLdi>(&artifact->payload)) {
      words.Append(*ldi, shadows[light]);
    } else if (const auto* map = std::get_if<ShadowWidthMap>(&artifact->payload)) {
      words.Append(*map, shadows[light]);
    } else {
      words.Append(std::get<ViewShadow>(artifact->payload), shadows[light]);
    }
  }
  if (auto status = Upload(context, std::move(words), std::move(shadows)); !status.ok()) {
    return status;
  }
  order_ = order;
  upload_count_ += static_cast<int64_t>(now.size());
  uploaded_ = std::move(now);
  return absl::OkStatus();
}

absl::Status WordPool::Upload(gl::Context& context, ShadowWords words,
                              std::vector<LightShadow> shadows) {
  const auto most = static_cast<size_t>(context.info().max_storage_bytes) / sizeof(uint32_t);
  if (words.words.size() > most) {
    return absl::ResourceExhaustedError(absl::StrFormat(
        "artifacts: found %.0f MB of maps and pixels, need at most %.0f MB to draw on "
        "this device: a lower resolution of the technique, or fewer lights",
        4e-6 * static_cast<double>(words.words.size()), 4e-6 * static_cast<double>(most)));
  }
  auto shadow_buffer = BufferOf(context, std::move(shadows));
  auto faces = BufferOf(context, std::move(words.faces));
  auto word_buffer = BufferOf(context, std::move(words.words));
  for (const auto* buffer : {&shadow_buffer, &faces, &word_buffer}) {
    if (!buffer->ok()) return buffer->status();
  }
  shadows_ = *std::move(shadow_buffer);
  faces_ = *std::move(faces);
  words_ = *std::move(word_buffer);
  return absl::OkStatus();
}

void WordPool::Bind(gl::Context& context) const {
  shadows_.BindStorage(context, kLightShadowsBinding);
  faces_.BindStorage(context, kLightFacesBinding);
  words_.BindStorage(context, kWordsBinding);
}

}  // namespace penumbra
