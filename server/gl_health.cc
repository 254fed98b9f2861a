#include "server/gl_health.h"

#include "grpcpp/health_check_service_interface.h"

namespace penumbra {

void GlHealth::Attach(grpc::HealthCheckServiceInterface* service) {
  const std::lock_guard lock(mutex_);
  service_ = service;
  service_->SetServingStatus(kGlHealthName, is_serving_);
}

void GlHealth::Detach() {
  const std::lock_guard lock(mutex_);
  service_ = nullptr;
}

void GlHealth::Set(bool is_serving) {
  const std::lock_guard lock(mutex_);
  is_serving_ = is_serving;
  if (service_) service_->SetServingStatus(kGlHealthName, is_serving_);
}

}  // namespace penumbra
