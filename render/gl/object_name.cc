#include "render/gl/object_name.h"

#include <utility>

#include "render/gl/context.h"

namespace penumbra::gl {

ObjectName::ObjectName(Context& context, uint32_t name, Delete deleter)
    : life_(context.life()), name_(name), delete_(deleter) {
  ++life_->object_count;
}

ObjectName::ObjectName(ObjectName&& other) noexcept
    : life_(std::exchange(other.life_, nullptr)),
      name_(std::exchange(other.name_, 0)),
      delete_(other.delete_) {}

ObjectName& ObjectName::operator=(ObjectName&& other) noexcept {
  std::swap(life_, other.life_);
  std::swap(name_, other.name_);
  std::swap(delete_, other.delete_);
  return *this;
}

ObjectName::~ObjectName() {
  if (life_ == nullptr) return;
  --life_->object_count;
  if (life_->context != nullptr && life_->context->MakeCurrent().ok()) delete_(name_);
}

}  // namespace penumbra::gl
