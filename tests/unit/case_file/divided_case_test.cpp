#include "proto/case_file/quality.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/fingerprint.hpp"

namespace dccast::case_file {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

v1::Case some_case() {
  v1::Case description;
  description.mutable_section()->set_half_width_m(0.28);
  description.add_monitor()->set_name("corner");
  apply_defaults(description);
  return description;
}

TEST(DividedCase, DividesCellsAndEveryStep) {
  v1::Case description = some_case();
  description.mutable_mesh()->set_refinement(2);
  auto& step = *description.mutable_time()->mutable_step_s();
  step.Clear();
  for (const double value : {0.25, 1.0}) {
    step.add_at(step.at_size());
    step.add_value(value);
  }
  description.mutable_time()->set_minimum_step_s(1e-3);
  const v1::Case fine = divided(description, 4);

  EXPECT_EQ(fine.mesh().refinement(), 8);
  EXPECT_THAT(fine.time().step_s().value(), ElementsAre(0.0625, 0.25));
  EXPECT_THAT(fine.time().step_s().at(), ElementsAre(0, 1));
  EXPECT_DOUBLE_EQ(fine.time().minimum_step_s(), 2.5e-4);
  EXPECT_EQ(fingerprint(description, Same::casting), fingerprint(fine, Same::casting));
}

TEST(DividedCase, IsAnotherCaseWhenAnythingElseDiffers) {
  const v1::Case description = some_case();
  const auto casting = [](const v1::Case& complete) {
    return fingerprint(complete, Same::casting);
  };
  v1::Case other = divided(description, 2);
  other.set_title("another title");
  other.mutable_limits()->set_maximum_nodes(1);
  EXPECT_EQ(casting(description), casting(other));
  other.mutable_section()->set_half_width_m(0.29);
  EXPECT_NE(casting(description), casting(other));
  other = divided(description, 2);
  other.mutable_mesh()->set_element(v1::P1);
  EXPECT_EQ(casting(description) == casting(other), description.mesh().element() == v1::P1);
}

TEST(DividedCase, SaysWhyACaseCannotBeDivided) {
  v1::Case description = some_case();
  EXPECT_EQ(reason_against_dividing(description), "");

  description.mutable_mesh()->set_file("slab.msh");
  EXPECT_THAT(reason_against_dividing(description), HasSubstr("mesh.file"));

  // A plan has cells and rows, which can be divided.
  description.mutable_section()->set_kind(v1::Section::QUARTER_SLAB);
  EXPECT_EQ(reason_against_dividing(description), "");
  description.mutable_mesh()->set_growth(false);
  EXPECT_THAT(reason_against_dividing(description), HasSubstr("mesh.file"));

  description = some_case();
  description.mutable_thermal()->set_file("temperatures.h5");
  EXPECT_THAT(reason_against_dividing(description), HasSubstr("thermal.file"));

  description = some_case();
  description.mutable_mechanics()->set_enabled(false);
  EXPECT_THAT(reason_against_dividing(description), HasSubstr("no curl"));

  description = some_case();
  description.clear_monitor();
  EXPECT_THAT(reason_against_dividing(description), HasSubstr("[[monitor]]"));
}

}  // namespace
}  // namespace dccast::case_file
