// Integrals of functions with kinks, to many digits.
#pragma once

#include <functional>

namespace penumbra {

// ∫_a^b f(x) dx by Gauss's rule of 10 points on intervals that are halved until halving changes
// nothing: until the changes add up to less than `relative_tolerance` of ∫|f|.
double AdaptiveIntegral(const std::function<double(double)>& f, double a, double b,
                        double relative_tolerance);

}  // namespace penumbra
