#include "core/linalg/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>

namespace dccast::linalg {

namespace {

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

void ConjugateGradients::mask(std::span<const char> held, std::vector<double>& v) const {
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (held[i] != 0) v[i] = 0.0;
  }
}

void ConjugateGradients::start(std::span<const double> b, std::span<const char> held) {
  vectors_.residual.assign(b.begin(), b.end());
  mask(held, vectors_.residual);
  for (auto* vector :
       {&vectors_.solution, &vectors_.preconditioned, &vectors_.direction, &vectors_.product})
    vector->resize(b.size());
}

CgOutcome ConjugateGradients::solve(const SparsityPattern& pattern, std::span<const double> values,
                                    std::span<const char> held, const Preconditioner& precondition,
                                    std::span<const double> b, std::span<double> x,
                                    const Limits& limits) {
  start(b, held);
  const auto precondition_free = [&] {
    precondition(vectors_.residual, vectors_.preconditioned);
    mask(held, vectors_.preconditioned);
  };
  const auto multiply_free = [&] {
    multiply(pattern, values, vectors_.direction, vectors_.product);
    mask(held, vectors_.product);
  };

  const double right_norm = std::sqrt(dot(vectors_.residual, vectors_.residual));
  const CgOutcome outcome =
      iterate_gradients(vectors_, right_norm, precondition_free, multiply_free, dot, limits);
  std::copy(vectors_.solution.begin(), vectors_.solution.end(), x.begin());
  return outcome;
}

}  // namespace dccast::linalg
