#include "core/material/norton_hoff.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dccast::material {
namespace {

class Yosida : public ::testing::TestWithParam<double> {};

TEST_P(Yosida, RootSolvesItsEquation) {
  const double q = GetParam();
  EXPECT_EQ(yosida_root(0.0, q), 1.0);

  double last = 1.0;
  for (double log_load = -22.0; log_load <= 24.0; log_load += 0.31) {
    const double load = std::pow(10.0, log_load);
    const double eta = yosida_root(load, q);
    // eta^(q-1) - eta^(q-2) is a difference of numbers of the size of eta^(q-1).
    const double size = std::pow(eta, q - 1.0);
    EXPECT_LE(std::abs(size - std::pow(eta, q - 2.0) - load), 1e-14 * size)
        << "load 1e" << log_load;
    EXPECT_GE(eta, last) << "the root grows with its load";
    last = eta;
  }
}

INSTANTIATE_TEST_SUITE_P(Exponents, Yosida, ::testing::Values(2.0, 3.0, 4.7, 6.0, 9.0));

/// With q = 2 the equation is linear; with q = 3 it is a quadratic one.
TEST(YosidaRoot, AgreesWithTheClosedForms) {
  for (double load : {1e-12, 1e-3, 0.7, 1.0, 42.0, 1e9}) {
    EXPECT_DOUBLE_EQ(yosida_root(load, 2.0), 1.0 + load);
    EXPECT_DOUBLE_EQ(yosida_root(load, 3.0), 0.5 + std::sqrt(0.25 + load));
  }
}

}  // namespace
}  // namespace dccast::material
