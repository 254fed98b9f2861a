// Integrals of smooth functions, to many digits.
#pragma once

#include <functional>

namespace penumbra {

// ∫_a^b f(x) dx by Gauss's rule of 10 points on intervals that are halved until halving changes an
// interval's share by less than `relative_tolerance` of a quarter of ∫|f|. `f` should be smooth
// between a and b: cut the integral at kinks.
double AdaptiveIntegral(const std::function<double(double)>& f, double a, double b,
                        double relative_tolerance);

}  // namespace penumbra
