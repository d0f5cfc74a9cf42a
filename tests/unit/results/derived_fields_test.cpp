#include "core/results/frame.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace dccast::results {
namespace {

/// One element, stressed as given.
Frame frame_of(int dimension, std::vector<double> stress) {
  Frame frame;
  frame.dimension = dimension;
  frame.nodes_per_element = dimension + 1;
  for (int n = 0; n <= dimension; ++n)
    for (int d = 0; d < dimension; ++d) frame.node.push_back(n == d + 1 ? 1.0 : 0.0);
  for (int n = 0; n <= dimension; ++n) frame.element_node.push_back(n);
  frame.stress = std::move(stress);
  return frame;
}

DerivedField field(const Frame& frame, const std::string& name) {
  const auto fields = derived_fields(frame);
  const auto found = std::ranges::find(fields, name, &DerivedField::name);
  EXPECT_NE(found, fields.end()) << name;
  return found == fields.end() ? DerivedField{} : *found;
}

/// The closed forms: |sigma| under tension, sqrt(3) tau in pure shear, nothing under pressure.
TEST(DerivedFields, VonMisesStressOfTensionShearAndPressure) {
  const auto von_mises = [](int dimension, std::vector<double> stress) {
    return field(frame_of(dimension, std::move(stress)), "von_mises_pa").values.at(0);
  };
  EXPECT_NEAR(von_mises(2, {7e6, 0, 0, 0}), 7e6, 1e-3);
  EXPECT_NEAR(von_mises(2, {0, 0, 0, -2e6}), std::sqrt(3.0) * 2e6, 1e-3);
  EXPECT_NEAR(von_mises(3, {0, -7e6, 0, 0, 0, 0}), 7e6, 1e-3);
  EXPECT_NEAR(von_mises(3, {5e6, 5e6, 5e6, 0, 0, 0}), 0.0, 1e-3);
  for (std::size_t shear : {3u, 4u, 5u}) {
    std::vector<double> stress(6, 1e6);
    for (std::size_t i = 3; i < 6; ++i) stress[i] = i == shear ? 2e6 : 0.0;
    EXPECT_NEAR(von_mises(3, stress), std::sqrt(3.0) * 2e6, 1e-3);
  }
}

/// Closed forms: tension with shear in a plane has s/2 +- sqrt(s^2/4 + t^2); a rotated tensor keeps
/// its principal values.
TEST(DerivedFields, MeanAndPrincipalStresses) {
  const auto of = [](int dimension, std::vector<double> stress, const char* name) {
    return field(frame_of(dimension, std::move(stress)), name).values;
  };
  EXPECT_THAT(of(2, {6e6, 0, 3e6, 4e6}, "mean_stress_pa"), ::testing::ElementsAre(3e6));
  EXPECT_THAT(of(2, {6e6, 0, 3e6, 4e6}, "principal_stress_pa"),
              ::testing::Pointwise(::testing::DoubleNear(1e-3), {8e6, 3e6, -2e6}));
  EXPECT_THAT(of(3, {0, 0, -1e6, 2e6, 0, 0}, "principal_stress_pa"),
              ::testing::Pointwise(::testing::DoubleNear(1e-3), {2e6, -1e6, -2e6}));
  EXPECT_THAT(of(3, {0, 0, 0, 0, 5e6, 0}, "principal_stress_pa"),
              ::testing::Pointwise(::testing::DoubleNear(1e-3), {5e6, 0.0, -5e6}));
  EXPECT_THAT(of(3, {1e6, 0, 0, 0, 0, 5e6}, "mean_stress_pa"),
              ::testing::Pointwise(::testing::DoubleNear(1e-6), {1e6 / 3.0}));
}

/// A bar that creeps by 1 % along its axis and keeps its volume; pure shear of gamma / 2 = 1 %.
TEST(DerivedFields, EquivalentViscoplasticStrain) {
  Frame frame = frame_of(2, {});
  frame.viscoplastic_strain = {0.01, -0.005, -0.005, 0.0};
  EXPECT_NEAR(field(frame, "equivalent_viscoplastic_strain").values.at(0), 0.01, 1e-15);
  frame = frame_of(3, {});
  frame.viscoplastic_strain = {0, 0, 0, 0, 0, 0.01};
  EXPECT_NEAR(field(frame, "equivalent_viscoplastic_strain").values.at(0), 0.02 / std::sqrt(3.0),
              1e-15);
}

TEST(DerivedFields, TheGapIsAFieldOnNodesThatIsUnknownAwayFromTheBottom) {
  Frame frame = frame_of(2, {});
  frame.bottom_node = {2, 0};
  frame.bottom_gap = {3e-3, 0.0};
  const auto gap = field(frame, "gap_m").values;
  EXPECT_EQ(gap.at(0), 0.0);
  EXPECT_TRUE(std::isnan(gap.at(1)));
  EXPECT_EQ(gap.at(2), 3e-3);
}

TEST(DerivedFields, ThePlaneDisplacementGetsAThirdComponent) {
  Frame frame = frame_of(2, {});
  frame.displacement = {1, 2, 3, 4, 5, 6};
  const DerivedField padded = field(frame, "displacement_xyz_m");
  EXPECT_EQ(padded.components, 3);
  EXPECT_THAT(padded.values, ::testing::ElementsAre(1, 2, 0, 3, 4, 0, 5, 6, 0));
  frame = frame_of(3, {});
  frame.displacement.assign(12, 1.0);
  EXPECT_TRUE(derived_fields(frame).empty()) << "it has three components already";
}

TEST(DerivedFields, PressureAndSolidFractionAreFieldsOnNodes) {
  Frame frame = frame_of(2, {});
  frame.liquid_fraction = {0.0, 0.25, 1.0};
  frame.bottom_node = {1, 0};
  frame.bottom_pressure = {5e3, 7e3};
  EXPECT_THAT(field(frame, "contact_pressure_pa").values, ::testing::ElementsAre(7e3, 5e3, 0.0));
  EXPECT_THAT(field(frame, "solid_fraction").values, ::testing::ElementsAre(1.0, 0.75, 0.0));
}

}  // namespace
}  // namespace dccast::results
