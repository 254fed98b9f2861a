#include "render/reference/adaptive_integral.h"

#include <array>
#include <cmath>

namespace penumbra {
namespace {

// Positive abscissae and weights of Gauss's rule of 10 points on [-1, 1].
constexpr std::array<double, 5> kNodes = {0.14887433898163122, 0.43339539412924719,
                                          0.67940956829902441, 0.86506336668898451,
                                          0.97390652851717172};
constexpr std::array<double, 5> kWeights = {0.29552422471475287, 0.26926671930999636,
                                            0.21908636251598204, 0.14945134915058059,
                                            0.06667134430868814};
constexpr int kFirstIntervals = 4;
// Below this the abscissae's rounding is all that halving finds.
constexpr int kMaxDepth = 12;

double Gauss(const std::function<double(double)>& f, double a, double b) {
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  double sum = 0;
  for (size_t k = 0; k < kNodes.size(); ++k) {
    sum += kWeights[k] * (f(middle - half * kNodes[k]) + f(middle + half * kNodes[k]));
  }
  return sum * half;
}

double Refine(const std::function<double(double)>& f, double a, double b, double whole,
              double tolerance, int depth) {
  const double middle = 0.5 * (a + b);
  const double left = Gauss(f, a, middle), right = Gauss(f, middle, b);
  if (depth >= kMaxDepth || std::abs(left + right - whole) <= tolerance) return left + right;
  return Refine(f, a, middle, left, tolerance, depth + 1) +
         Refine(f, middle, b, right, tolerance, depth + 1);
}

}  // namespace

double AdaptiveIntegral(const std::function<double(double)>& f, double a, double b,
                        double relative_tolerance) {
  if (!(a < b)) return 0;
  const auto magnitude = [&f](double x) { return std::abs(f(x)); };
  const double step = (b - a) / kFirstIntervals;
  double size = 0;
  for (int i = 0; i < kFirstIntervals; ++i)
    size += Gauss(magnitude, a + i * step, a + (i + 1) * step);
  const double tolerance = relative_tolerance * size / kFirstIntervals;
  double sum = 0;
  for (int i = 0; i < kFirstIntervals; ++i) {
    const double from = a + i * step, to = from + step;
    sum += Refine(f, from, to, Gauss(f, from, to), tolerance, 0);
  }
  return sum;
}

}  // namespace penumbra
