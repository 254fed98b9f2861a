// Blobs as bytes, so that they can be wrong: the layouts are those of render/scene/blob.h.
//
//   UploadBytes(*client_, BlobBytes(kMeshMagic).Words({3, 3, 0}).Floats({…}).Words({0, 1, 2}))
#pragma once

#include <cstring>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "proto/convert/geometry_convert.h"
#include "render/scene/content_hash.h"
#include "tests/integration/service/wire_client.h"

namespace penumbra::testing {

inline constexpr char kMeshMagic[] = "PNMM";
inline constexpr char kMaskMagic[] = "PNMA";

class BlobBytes {
 public:
  explicit BlobBytes(const char* magic) : bytes_(magic, 4) { Words({1}); }

  BlobBytes& Words(const std::vector<uint32_t>& words) { return Append(words); }
  BlobBytes& Floats(const std::vector<float>& floats) { return Append(floats); }
  BlobBytes& Text(const std::string& text) {
    bytes_ += text;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  template <typename T>
  BlobBytes& Append(const std::vector<T>& values) {
    const size_t at = bytes_.size();
    bytes_.resize(at + values.size() * sizeof(T));
    if (!values.empty()) std::memcpy(bytes_.data() + at, values.data(), values.size() * sizeof(T));
    return *this;
  }

  std::string bytes_;
};

// A triangle in the plane y = 1, of `positions` where they are given.
inline BlobBytes TriangleBytes(const std::vector<uint32_t>& indices = {0, 1, 2},
                               const std::vector<float>& positions = {-1, 1, 1, 1, 1, 1, 0, 1,
                                                                      -1}) {
  return BlobBytes(kMeshMagic)
      .Words(
          {static_cast<uint32_t>(positions.size() / 3), static_cast<uint32_t>(indices.size()), 0})
      .Floats(positions)
      .Words(indices);
}

inline std::string HashOf(const std::string& bytes) {
  return ToProto(Sha256(std::as_bytes(std::span(bytes))));
}

// In one message, under the name that its bytes have or another.
inline absl::StatusOr<v1::UploadBlobResponse> UploadBytes(WireClient& client,
                                                          const std::string& bytes,
                                                          const std::string& hash) {
  std::vector<v1::UploadBlobRequest> requests(1);
  requests[0].mutable_header()->set_hash(hash);
  requests[0].mutable_header()->set_size_bytes(bytes.size());
  requests[0].set_data(bytes);
  return client.Upload(requests);
}
inline absl::StatusOr<v1::UploadBlobResponse> UploadBytes(WireClient& client,
                                                          const BlobBytes& blob) {
  return UploadBytes(client, blob.bytes(), HashOf(blob.bytes()));
}

}  // namespace penumbra::testing
