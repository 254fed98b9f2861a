// Meshes and masks as bytes of a client: what is taken is named by its content, is written as it
// was read, and can be asked for all that is found on first use.

#include "render/scene/blob.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "tests/fuzz/kit/put_word.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/kit/target.h"
#include "tests/fuzz/targets/small_studio.h"
#include "tests/support/shapes.h"

namespace penumbra::fuzzing {
namespace {

enum Kind : uint8_t { kWhole, kMeshOf, kMaskOf, kKinds };

std::string TextOf(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// A mesh of which the header is right: payload V, T, flags, and numbers and indices as they come.
std::string MeshOf(const std::string& payload) {
  if (payload.size() < 3) return payload;
  const auto at = [&](size_t i) { return static_cast<uint8_t>(payload[i]); };
  const uint32_t vertices = at(0) % 64, corners = 3 * (at(1) % 64), flags = at(2) % 4;
  std::string blob = "PNMM";
  for (const uint32_t word : {1u, vertices, corners, flags}) PutWord(word, blob);
  std::string rest = payload.substr(3);
  rest.resize(vertices * (12 + (flags & 1 ? 12 : 0) + (flags & 2 ? 8 : 0)));
  blob += rest;
  // After the numbers a byte a corner, so that most are vertices.
  for (uint32_t i = 0; i < corners; ++i) {
    const size_t from = 3 + rest.size() + i;
    PutWord(from < payload.size() ? at(from) % std::max(vertices, 1u) : 0, blob);
  }
  return blob;
}

// Payload: width, height, opacities.
std::string MaskOf(const std::string& payload) {
  if (payload.size() < 2) return payload;
  const auto at = [&](size_t i) { return static_cast<uint8_t>(payload[i]); };
  std::string blob = "PNMA";
  for (const uint32_t word : {1u, uint32_t{at(0)}, uint32_t{at(1)}}) PutWord(word, blob);
  std::string rest = payload.substr(2);
  rest.resize(size_t{at(0)} * at(1));
  return blob + rest;
}

void CheckMesh(const Mesh& mesh, const SceneLimits& limits) {
  Require(mesh.vertex_count() <= limits.max_vertices_per_mesh &&
              mesh.triangle_count() <= limits.max_triangles_per_mesh,
          "a mesh keeps to its limits");
  Require(std::ranges::all_of(mesh.indices(), [&](auto i) { return i < mesh.vertex_count(); }),
          "corners are vertices");
  for (const Vec3& p : mesh.positions()) {
    for (int c = 0; c < 3; ++c) {
      Require(std::abs(p[c]) <= limits.max_coordinate, "places are within the limits");
      Require(p[c] >= mesh.bounds().min[c] && p[c] <= mesh.bounds().max[c], "bounds hold all");
      Require(!(p[c] == 0 && std::signbit(p[c])), "no zero is negative");
    }
  }
  Require(mesh.degenerate_triangle_count() <= mesh.triangle_count(), "parts are not more than all");
  mesh.closure();
  mesh.silhouette_edges();
  mesh.triangle_clusters();
  mesh.planar_surfaces();
}

void CheckMask(const AlphaMask& mask, const SceneLimits& limits) {
  Require(mask.width() > 0 && mask.height() > 0 && mask.width() <= limits.max_mask_side &&
              mask.height() <= limits.max_mask_side,
          "a mask keeps to its limits");
  for (const Vec2& uv : {Vec2(0), Vec2(1), Vec2(-0.25f, 7.5f), Vec2(1e9f, -1e9f), Vec2(-1e-30f)}) {
    const float opacity = mask.At(uv);
    Require(opacity >= 0 && opacity <= 1, "an opacity is one");
  }
}

class Blobs final : public Target {
 public:
  std::span<const StepKind> kinds() const override { return kinds_; }
  void Run(const Script& script) override;
  std::vector<Seed> Seeds() override;

 private:
  void Try(const std::string& bytes);
  void CheckWritten(const BlobContent& content, const std::string& bytes) const;

  const SceneLimits limits_ = SmallLimits();
  const StepKind kinds_[kKinds] = {{"whole"}, {"mesh of"}, {"mask of"}};
};

void Blobs::Run(const Script& script) {
  for (const Step& step : script) {
    const uint8_t kind = step.kind % kKinds;
    Try(kind == kMeshOf   ? MeshOf(step.payload)
        : kind == kMaskOf ? MaskOf(step.payload)
                          : step.payload);
  }
}

void Blobs::Try(const std::string& bytes) {
  const auto content = DecodeBlob(std::as_bytes(std::span(bytes)), limits_);
  Count(content.ok());
  if (!content.ok()) return RequireRefusal(content.status());
  if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&*content)) {
    CheckMesh(**mesh, limits_);
  } else {
    CheckMask(*std::get<std::shared_ptr<const AlphaMask>>(*content), limits_);
  }
  CheckWritten(*content, bytes);
}

void Blobs::CheckWritten(const BlobContent& content, const std::string& bytes) const {
  const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&content);
  const auto* mask = std::get_if<std::shared_ptr<const AlphaMask>>(&content);
  const ContentHash id = mesh ? (*mesh)->id() : (*mask)->id();
  const std::vector<std::byte> written =
      mesh ? EncodeBlob((*mesh)->geometry()) : EncodeBlob(**mask);
  Require(written.size() == bytes.size(), "a blob is as long as it was");
  Require(Sha256(written) == id, "a blob's name is its hash");
  const auto again = DecodeBlob(written, limits_);
  Require(again.ok(), "what is written can be read");
  const EncodedBlob encoded(content);
  Require(encoded.size() == written.size(), "both ways of writing are one");
  // In chunks that do not end where its parts do.
  std::vector<std::byte> copied(written.size());
  for (size_t at = 0; at < copied.size(); at += 13) {
    encoded.CopyTo(copied.data() + at, at, std::min<size_t>(13, copied.size() - at));
  }
  Require(copied == written, "both ways of writing are one");
}

std::vector<Seed> Blobs::Seeds() {
  const std::string ball = TextOf(EncodeBlob(testing::BallGeometry(6, 4)));
  const std::string box = TextOf(EncodeBlob(testing::UnitBoxGeometry()));
  const std::string square = TextOf(EncodeBlob(testing::UnitSquareGeometry()));
  const std::string mask = TextOf(EncodeBlob(*StudioMask()));
  // The square's vertices, and their corners as bytes.
  const std::string part = std::string("\x04\x02\x00", 3) + square.substr(20, 48) +
                           std::string("\x00\x01\x02\x00\x02\x03", 6);
  const std::string truncated = box.substr(0, box.size() - 3);
  return {{"ball", {{kWhole, ball}}},
          {"square", {{kWhole, square}}},
          {"mask", {{kWhole, mask}}},
          {"parts",
           {{kMeshOf, part},
            {kMaskOf,
             "\x03\x02"
             "abcdef"}}},
          {"cut", {{kWhole, truncated}, {kWhole, box}}}};
}

}  // namespace

Target& TheTarget() {
  static Blobs target;
  return target;
}

}  // namespace penumbra::fuzzing
