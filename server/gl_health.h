// What the health service says of the GL, as the GL worker tells it.
//
//   GlHealth health;
//   gl::Worker::Create({.on_health_change = [&](bool degraded) { health.Set(!degraded); }});
//   health.Attach(server->GetHealthCheckService());   // …
//   health.Detach();                                  // before the server goes
#pragma once

#include <mutex>

namespace grpc {
class HealthCheckServiceInterface;
}

namespace penumbra {

// What the health service calls the GL; it is not serving where the server is degraded.
inline constexpr char kGlHealthName[] = "penumbra.gl";

// Any thread may set it; nobody is told before Attach and after Detach.
class GlHealth {
 public:
  void Attach(grpc::HealthCheckServiceInterface* service);
  void Detach();
  void Set(bool is_serving);

 private:
  std::mutex mutex_;
  bool is_serving_ = false;
  grpc::HealthCheckServiceInterface* service_ = nullptr;
};

}  // namespace penumbra
