#include "proto/frames/contraction.hpp"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/frames/cooled_slab.hpp"

namespace dccast::frames {
namespace {

using namespace frames::testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Rows every 50 mm, solid up to a height; above half a metre the middle pulls in by 1 mm/m more.
Contraction rising(double solid_up_to_m) {
  Contraction contraction{1600.0, 1.5, {}};
  for (int i = 0; i <= 30; ++i) {
    FaceRow row{0.05 * i, 0.05 * i <= solid_up_to_m + 1e-9, {}};
    row.points = {{0.0, 0.303, 0.3, 0.2940 - 1e-3 * std::max(0.0, row.height_m - 0.5)},
                  {0.66, 0.291, 0.29, 0.2853}};
    contraction.rows.push_back(row);
  }
  return contraction;
}

TEST(SteadyFace, IsReadAtNineTenthsOfTheSolidHeight) {
  const SteadyFace face = steady_face(rising(1.0));
  EXPECT_NEAR(face.height_m, 0.9, 1e-9);
  EXPECT_THAT(face.x_m, ElementsAre(0.0, 0.66));
  EXPECT_THAT(face.mould_m, ElementsAre(0.303, 0.291));
  EXPECT_NEAR(face.cold_m[0], 0.2936, 1e-12);
  EXPECT_NEAR(face.change_m, 0.15e-3, 1e-12) << "from 0.75 m to 0.9 m";
  EXPECT_NEAR(face.residual_m(0.290), 4.7e-3, 1e-12) << "of both sides the larger";
}

TEST(SteadyFace, NeedsMetalThatIsSolidAboveTheButt) {
  EXPECT_NO_THROW(steady_face(rising(0.35)));
  try {
    steady_face(rising(0.3));
    FAIL() << "0.27 m is within the butt";
  } catch (const NoContraction& error) {
    EXPECT_THAT(error.what(), HasSubstr("solid only up to 300 mm"));
    EXPECT_THAT(error.what(), HasSubstr("later time.end"));
  }
  EXPECT_THROW(steady_face(contraction_of(quarter_slab(), cooled([](double) { return 640.0; }))),
               NoContraction);
}

TEST(SteadyFace, TheOpeningIsTheTableOfTheCase) {
  const v1::Case slab = quarter_slab();
  EXPECT_DOUBLE_EQ(half_opening_m(slab.section(), 0.1), 0.300);
  EXPECT_NEAR(half_opening_m(slab.section(), 0.48), 0.295, 1e-12);
}

}  // namespace
}  // namespace dccast::frames
