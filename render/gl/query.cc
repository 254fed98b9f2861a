#include "render/gl/query.h"

#include "render/gl/gl.h"

namespace penumbra::gl {
namespace {

void Delete(uint32_t name) { glDeleteQueries(1, &name); }

GLenum Target(Query::Kind kind) {
  return kind == Query::Kind::kSamplesPassed ? GL_SAMPLES_PASSED : GL_TIME_ELAPSED;
}

}  // namespace

absl::StatusOr<Query> Query::Create(Context& context, Kind kind) {
  if (absl::Status status = context.MakeCurrent(); !status.ok()) return status;
  GLuint name = 0;
  glCreateQueries(Target(kind), 1, &name);
  Query query;
  query.name_ = ObjectName(context, name, &Delete);
  query.kind_ = kind;
  if (absl::Status status = context.Check("gl::Query"); !status.ok()) return status;
  return query;
}

void Query::Begin(Context& context) {
  if (context.MakeCurrent().ok()) glBeginQuery(Target(kind_), name_.get());
}

void Query::End(Context& context) {
  if (context.MakeCurrent().ok()) glEndQuery(Target(kind_));
}

uint64_t Query::Wait(Context& context) const {
  GLuint64 value = 0;
  if (context.MakeCurrent().ok()) glGetQueryObjectui64v(name_.get(), GL_QUERY_RESULT, &value);
  return value;
}

}  // namespace penumbra::gl
