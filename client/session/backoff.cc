#include "client/session/backoff.h"

#include <random>

namespace penumbra {
namespace {

double Between(double least, double most) {
  static thread_local std::minstd_rand random(std::random_device{}());
  return std::uniform_real_distribution<double>(least, most)(random);
}

}  // namespace

double Jittered(double seconds) { return Between(0.5, 1.0) * seconds; }

double JitteredAfter(double seconds) { return Between(1.0, 1.5) * seconds; }

}  // namespace penumbra
