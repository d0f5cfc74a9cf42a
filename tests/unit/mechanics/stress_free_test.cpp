#include <gtest/gtest.h>

#include "tests/unit/mechanics/bodies.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

template <class Element>
class StressFreeOn : public ::testing::Test {};
using Families = ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::BendingQuadrilateral>;
TYPED_TEST_SUITE(StressFreeOn, Families);

/// A free block that cools evenly, without weight: nothing but the round-off of strains that cancel
/// acts in its plane, and a residual of that size must count as none. In plane strain the block
/// shrinks by (1 + nu) times its thermal stretch.
TYPED_TEST(StressFreeOn, ABlockWithoutWeightConvergesOnRoundOff) {
  constexpr double stretch = -0.0169, poisson = 0.3;
  for (const bool contact : {false, true}) {
    for (const Algorithm algorithm :
         {Algorithm::newton, Algorithm::vnbm, Algorithm::nbm, Algorithm::sbm}) {
      FixedBody<TypeParam> body(distorted_rectangle<TypeParam>(0.28, 0.1, 8, 5));
      body.set_material(6e10, poisson, 0.0, 6.0);
      for (double& thermal : body.problem.thermal) thermal = stretch;
      for (int n = 0; n < body.mesh.nodes(); ++n) {
        if (body.mesh.point(n)[0] == 0.0) body.fix(n, 0, 0.0);
        if (!contact && body.mesh.point(n)[1] == 0.0) body.fix(n, 1, 0.0);
      }
      if (contact) body.set_contact();
      Options options = tight(1e-9);
      options.algorithm = algorithm;
      options.parameters.gamma_c = 1e11;
      const auto outcome = body.step(options, 1.0);
      EXPECT_TRUE(outcome.converged) << "algorithm " << int(algorithm) << ", contact " << contact
                                     << ", residual " << outcome.equilibrium_residual;
      EXPECT_LE(outcome.contact_changes, 2);
      for (int n = 0; n < body.mesh.nodes(); ++n) {
        for (std::size_t d = 0; d < 2; ++d) {
          const double exact = (1.0 + poisson) * stretch * body.mesh.point(n)[d];
          EXPECT_NEAR(body.displacement()[2 * std::size_t(n) + d], exact, 1e-12);
        }
      }
    }
  }
}

}  // namespace
}  // namespace dccast::mechanics
