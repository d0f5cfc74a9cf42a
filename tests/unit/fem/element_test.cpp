#include "core/fem/element.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dccast::fem {
namespace {

template <class Element>
class Elements : public ::testing::Test {};
using Families = ::testing::Types<P1Triangle, Q1Quadrilateral, P1Tetrahedron, Q1Hexahedron>;
TYPED_TEST_SUITE(Elements, Families);

/// A few points of the reference cell, inside both a triangle and a cube.
template <class Element>
std::array<double, Element::dimension> some_point(int i) {
  std::array<double, Element::dimension> p{};
  for (std::size_t d = 0; d < p.size(); ++d) {
    p[d] = 0.05 + 0.17 * std::abs(std::sin(1.0 + 2.0 * i + 3.0 * static_cast<double>(d)));
  }
  return p;
}

TYPED_TEST(Elements, ShapeFunctionsSumToOneAndTheirGradientsToZero) {
  for (int i = 0; i < 5; ++i) {
    const auto p = some_point<TypeParam>(i);
    double sum = 0.0;
    for (double n : TypeParam::shape(p)) sum += n;
    EXPECT_NEAR(sum, 1.0, 1e-15);
    for (std::size_t d = 0; d < std::size_t(TypeParam::dimension); ++d) {
      double gradient = 0.0;
      for (const auto& g : TypeParam::shape_gradient(p)) gradient += g[d];
      EXPECT_NEAR(gradient, 0.0, 1e-15);
    }
  }
}

/// Along each axis the functions are linear, so that central differences are exact.
TYPED_TEST(Elements, GradientsAreThoseOfTheShapeFunctions) {
  constexpr double h = 0.01;
  for (int i = 0; i < 5; ++i) {
    const auto p = some_point<TypeParam>(i);
    const auto gradient = TypeParam::shape_gradient(p);
    for (std::size_t d = 0; d < std::size_t(TypeParam::dimension); ++d) {
      auto ahead = p, behind = p;
      ahead[d] += h, behind[d] -= h;
      const auto more = TypeParam::shape(ahead), less = TypeParam::shape(behind);
      for (std::size_t n = 0; n < std::size_t(TypeParam::nodes); ++n) {
        EXPECT_NEAR((more[n] - less[n]) / (2.0 * h), gradient[n][d], 1e-13);
      }
    }
  }
}

/// Integral of x^powers over the reference cell by the element's own points.
template <class Element>
double integral(const std::array<int, Element::dimension>& powers) {
  double sum = 0.0;
  for (std::size_t q = 0; q < std::size_t(Element::points); ++q) {
    double term = Element::weight[q];
    for (std::size_t d = 0; d < powers.size(); ++d)
      term *= std::pow(Element::point[q][d], powers[d]);
    sum += term;
  }
  return sum;
}

TEST(Quadrature, OnePointOfTheTriangleIntegratesLinearFunctions) {
  EXPECT_DOUBLE_EQ(integral<P1Triangle>({0, 0}), 0.5);
  EXPECT_DOUBLE_EQ(integral<P1Triangle>({1, 0}), 1.0 / 6.0);
  EXPECT_DOUBLE_EQ(integral<P1Triangle>({0, 1}), 1.0 / 6.0);
}

TEST(Quadrature, GaussPointsIntegrateCubicsInEachDirection) {
  const auto exact = [](int power) { return power % 2 == 0 ? 2.0 / (power + 1.0) : 0.0; };
  for (int a = 0; a <= 3; ++a) {
    for (int b = 0; b <= 3; ++b) {
      EXPECT_NEAR((integral<Q1Quadrilateral>({a, b})), exact(a) * exact(b), 1e-15);
      for (int c = 0; c <= 3; ++c) {
        EXPECT_NEAR((integral<Q1Hexahedron>({a, b, c})), exact(a) * exact(b) * exact(c), 1e-14);
      }
    }
  }
}

}  // namespace
}  // namespace dccast::fem
