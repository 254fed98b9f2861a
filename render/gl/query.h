// How many samples passed, or how long the GPU took.
//
//   auto query = gl::Query::Create(context, gl::Query::Kind::kElapsedNanoseconds);
//   query->Begin(context); … draw … query->End(context);
//   uint64_t ns = query->Wait(context);
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "render/gl/context.h"

namespace penumbra::gl {

class Query {
 public:
  enum class Kind { kSamplesPassed, kElapsedNanoseconds };

  static absl::StatusOr<Query> Create(Context& context, Kind kind);

  void Begin(Context& context);
  void End(Context& context);
  // Waits until the GPU is done with what lies between Begin and End.
  uint64_t Wait(Context& context) const;

 private:
  ObjectName name_;
  Kind kind_ = Kind::kSamplesPassed;
};

}  // namespace penumbra::gl
