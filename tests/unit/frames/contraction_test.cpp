#include "proto/frames/contraction.hpp"

#include <gtest/gtest.h>

#include "tests/unit/frames/cooled_slab.hpp"

namespace dccast::frames {
namespace {

using namespace frames::testing;

TEST(Contraction, AFreeBlockHasThatOfItsTemperatureNowAndAt20Degrees) {
  const Contraction contraction = contraction_of(quarter_slab(), cooled(uniform));
  EXPECT_EQ(contraction.time_s, 1000.0);
  EXPECT_EQ(contraction.cast_length_m, 0.95);
  ASSERT_EQ(contraction.rows.size(), height_m.size());

  for (std::size_t r = 0; r < height_m.size(); ++r) {
    const FaceRow& row = contraction.rows[r];
    EXPECT_NEAR(row.height_m, height_m[r], 1e-9);
    EXPECT_TRUE(row.solid);
    ASSERT_EQ(row.points.size(), along_m.size());
    for (std::size_t i = 0; i < along_m.size(); ++i) {
      EXPECT_NEAR(row.points[i].x_m, along_m[i], 1e-9);
      EXPECT_NEAR(row.points[i].mould_m, opening_m[i], 1e-12);
      EXPECT_NEAR(row.points[i].now_m, opening_m[i] * stretch(320.0), 1e-12);
      EXPECT_NEAR(row.points[i].cold_m, opening_m[i] * stretch(20.0), 1e-12);
      EXPECT_NEAR(row.points[i].cold_pull_in_m(), opening_m[i] * (1.0 - stretch(20.0)), 1e-12);
    }
  }
}

TEST(Contraction, TheHeadIsTheHighestRowThatIsSolidAllThrough) {
  const Contraction contraction = contraction_of(quarter_slab(), cooled(hot_above));
  EXPECT_NEAR(contraction.head().height_m, 0.2, 1e-9);
  EXPECT_NEAR(contraction.at(0.06).height_m, 0.05, 1e-9);
  EXPECT_FALSE(contraction.rows.back().solid);
  EXPECT_TRUE(std::isnan(contraction.rows.back().points[0].cold_m));
  const Contraction liquid = contraction_of(quarter_slab(), cooled([](double) { return 640.0; }));
  EXPECT_NEAR(liquid.head().height_m, 0.4, 1e-9) << "none is solid";
}

TEST(Contraction, OtherSectionsAndUnfitMeshesAreRefused) {
  v1::Frame frame = cooled(uniform);
  v1::Case section = quarter_slab();
  section.mutable_section()->clear_half_thickness_m();
  EXPECT_THROW(contraction_of(section, frame), NoContraction);
  v1::Frame without_mechanics = frame;
  without_mechanics.clear_displacement_m();
  EXPECT_THROW(contraction_of(quarter_slab(), without_mechanics), NoContraction);
  for (int n = 0; n < frame.temperature_c_size(); ++n) frame.set_node_m(3 * n + 2, 1e-3 * n);
  EXPECT_THROW(contraction_of(quarter_slab(), frame), NoContraction) << "no two nodes are level";
}

}  // namespace
}  // namespace dccast::frames
