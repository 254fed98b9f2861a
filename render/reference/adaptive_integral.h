// Integrals of functions with kinks, to many digits.
#pragma once

#include <functional>

namespace penumbra {

// ∫_a^b f(x) dx by Gauss's rule of 10 points on intervals that are halved until halving changes an
// interval's share by less than `relative_tolerance` of ∫|f|. Kinks are closed in upon; few intervals
// are left in doubt, so the whole is about as good.
double AdaptiveIntegral(const std::function<double(double)>& f, double a, double b,
                        double relative_tolerance);

}  // namespace penumbra
