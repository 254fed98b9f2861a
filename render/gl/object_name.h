// What owns a GL object.
//
//   ObjectName name(context, buffer, [](uint32_t buffer) { glDeleteBuffers(1, &buffer); });
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

namespace penumbra::gl {

class Context;

// What GL objects share with their context, so that they may outlive it.
struct ContextLife {
  Context* context = nullptr;  // null once it is gone: its objects went with it
  std::atomic<int> object_count = 0;
};

// The name of a GL object and the duty to delete it. Move-only. Deletes on the context's thread
// while the context lives; afterwards there is nothing to delete.
class ObjectName {
 public:
  using Delete = void (*)(uint32_t name);

  ObjectName() = default;
  ObjectName(Context& context, uint32_t name, Delete deleter);
  ObjectName(ObjectName&& other) noexcept;
  ObjectName& operator=(ObjectName&& other) noexcept;
  ~ObjectName();

  uint32_t get() const { return name_; }

 private:
  std::shared_ptr<ContextLife> life_;
  uint32_t name_ = 0;
  Delete delete_ = nullptr;
};

}  // namespace penumbra::gl
