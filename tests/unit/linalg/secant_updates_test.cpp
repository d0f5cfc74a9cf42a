#include "core/linalg/secant_updates.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace dccast::linalg {
namespace {

using Vector = std::vector<double>;

// A positive definite matrix, and a diagonal "factor" that is far from it.
const std::vector<Vector> matrix{
    {7.0, 2.0, -1.0, 0.5}, {2.0, 5.0, 1.0, 0.0}, {-1.0, 1.0, 9.0, 2.0}, {0.5, 0.0, 2.0, 3.0}};
const Vector factor{1.0, 2.0, 30.0, 0.5};

Vector times_matrix(const Vector& x) {
  Vector y(x.size(), 0.0);
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t j = 0; j < x.size(); ++j) y[i] += matrix[i][j] * x[j];
  return y;
}

/// The updated inverse times a vector.
Vector solve(SecantUpdates& updates, Vector b) {
  updates.before_solution(b);
  for (std::size_t i = 0; i < b.size(); ++i) b[i] /= factor[i];
  updates.after_solution(b);
  return b;
}

Vector unit(std::size_t i) {
  Vector x(factor.size(), 0.0);
  x[i] = 1.0;
  return x;
}

TEST(SecantUpdates, WithoutPairsTheFactorIsUsedAsItIs) {
  SecantUpdates updates;
  updates.resize(factor.size());
  EXPECT_EQ(solve(updates, {1.0, 2.0, 30.0, 0.5}), (Vector{1.0, 1.0, 1.0, 1.0}));
}

TEST(SecantUpdates, TheNewestPairIsMappedExactly) {
  SecantUpdates updates;
  updates.resize(factor.size());
  const Vector steps[] = {{1.0, 0.0, 0.5, 0.0}, {0.3, -1.0, 0.0, 2.0}, {0.0, 0.1, -0.7, 1.0}};
  for (const Vector& step : steps) {
    updates.add(step, times_matrix(step));
    const Vector found = solve(updates, times_matrix(step));
    for (std::size_t i = 0; i < step.size(); ++i) EXPECT_NEAR(found[i], step[i], 1e-13);
  }
  EXPECT_EQ(updates.pairs(), 3U);
}

TEST(SecantUpdates, ConjugateStepsInAllDirectionsGiveTheInverse) {
  SecantUpdates updates;
  updates.resize(factor.size());
  std::vector<Vector> conjugate;
  for (std::size_t k = 0; k < factor.size(); ++k) {
    Vector step = unit(k);  // made conjugate to those before it (Gram and Schmidt)
    for (const Vector& other : conjugate) {
      const Vector change = times_matrix(other);
      double above = 0.0, below = 0.0;
      for (std::size_t i = 0; i < step.size(); ++i) {
        above += step[i] * change[i];
        below += other[i] * change[i];
      }
      for (std::size_t i = 0; i < step.size(); ++i) step[i] -= above / below * other[i];
    }
    conjugate.push_back(step);
    updates.add(step, times_matrix(step));
  }

  const Vector x{0.3, -2.0, 1.0, 5.0};
  const Vector found = solve(updates, times_matrix(x));
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(found[i], x[i], 1e-12);
}

TEST(SecantUpdates, TheInverseStaysSymmetric) {
  SecantUpdates updates;
  updates.resize(factor.size());
  // Changes of another matrix than that of the factor, as between two tangents.
  updates.add(Vector{1.0, 2.0, 0.0, 0.0}, Vector{3.0, 1.0, 0.2, 0.0});
  updates.add(Vector{0.0, 1.0, 1.0, -1.0}, Vector{0.5, 4.0, 1.0, 0.1});
  for (std::size_t i = 0; i < factor.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_NEAR(solve(updates, unit(i))[j], solve(updates, unit(j))[i], 1e-13);
}

TEST(SecantUpdates, APairWithoutPositiveWorkIsSkipped) {
  SecantUpdates updates;
  updates.resize(factor.size());
  updates.add(Vector{1.0, 0.0, 0.0, 0.0}, Vector{-1.0, 0.0, 0.0, 0.0});
  updates.add(Vector{0.0, 0.0, 0.0, 0.0}, Vector{0.0, 0.0, 0.0, 0.0});
  EXPECT_EQ(updates.pairs(), 0U);
}

TEST(SecantUpdates, ItIsFullAndBeginsAgain) {
  SecantUpdates updates;
  updates.resize(factor.size());
  while (!updates.full()) updates.add(unit(0), unit(0));
  EXPECT_EQ(updates.pairs(), SecantUpdates::most);
  updates.clear();
  EXPECT_EQ(updates.pairs(), 0U);
  EXPECT_EQ(solve(updates, factor), (Vector{1.0, 1.0, 1.0, 1.0}));
}

}  // namespace
}  // namespace dccast::linalg
