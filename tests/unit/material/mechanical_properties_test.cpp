#include "core/material/mechanical_properties.hpp"

#include <gtest/gtest.h>

#include "tests/unit/material/paper_card.hpp"

namespace dccast::material {
namespace {

const MechanicalProperties paper(testing::paper_card());

/// numerics 1.4: Table 9 is held constant outside its range.
TEST(MechanicalProperties, ElasticConstantsOfTheHotMetalAreThoseOfTheTable) {
  const double mu = paper.shear_modulus(649.0);
  EXPECT_NEAR(mu, 1.3793e10, 0.5e6);
  EXPECT_NEAR(paper.bulk_modulus(649.0) - 2.0 / 3.0 * mu, 1.2414e11, 0.5e7);
  EXPECT_EQ(paper.shear_modulus(700.0), mu);
  EXPECT_DOUBLE_EQ(paper.shear_modulus(20.0), 67e9 / (2.0 * 1.3134));
}

/// As with the tables, what lies above the liquidus is not extrapolated: Arrhenius' factor would be
/// 12 times larger at 780 °C.
TEST(MechanicalProperties, CreepAboveTheLiquidusIsThatOfTheLiquidus) {
  EXPECT_EQ(paper.creep_factors(780.0).deviatoric, paper.creep_factors(649.0).deviatoric);
  EXPECT_EQ(paper.creep_factors(649.0).deviatoric, paper.creep().kappa(649.0));
  EXPECT_LT(paper.creep_factors(640.0).deviatoric, paper.creep_factors(649.0).deviatoric);
}

/// numerics 1.11: -4.33 % from the liquidus to 20 °C, -2.64 % of it in the mushy interval.
TEST(MechanicalProperties, ThermalStretchHasTheClosedForm) {
  EXPECT_EQ(paper.thermal_stretch(649.0), 1.0);
  EXPECT_NEAR(paper.thermal_stretch(20.0) - 1.0, -0.0433, 5e-5);
  EXPECT_NEAR(paper.thermal_stretch(620.0) - 1.0, -0.0264, 5e-5);
  for (double t : {20.0, 400.0, 630.0}) {
    const double stretch = paper.thermal_stretch(t);
    EXPECT_NEAR(stretch * stretch * stretch * paper.density(t), paper.liquid_density(), 1e-9);
  }
}

}  // namespace
}  // namespace dccast::material
