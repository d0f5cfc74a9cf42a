#include "client/contraction.hpp"

#include <array>
#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/failure.hpp"
#include "client/message_json.hpp"
#include "client_run.hpp"
#include "fake_service.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;

constexpr double liquidus_c = 649.0;
constexpr std::array height_m{0.0, 0.05, 0.2, 0.4};
constexpr std::array along_m{0.0, 0.3, 0.66};
constexpr std::array opening_m{0.300, 0.300, 0.290};

double density(double temperature_c) {
  return 2700.0 - 0.5 * temperature_c;
}

/// Length over that at the liquidus.
double stretch(double temperature_c) {
  return std::cbrt(density(liquidus_c) / density(temperature_c));
}

void add_point(v1::Curve& curve, double at, double value) {
  curve.add_at(at);
  curve.add_value(value);
}

v1::Case quarter_slab() {
  v1::Case solved;
  for (std::size_t i = 1; i < along_m.size(); ++i)
    add_point(*solved.mutable_section()->mutable_half_thickness_m(), along_m[i], opening_m[i]);
  for (const double temperature_c : {0.0, 1000.0})
    add_point(*solved.mutable_alloy()->mutable_density_kg_per_m3(), temperature_c,
              density(temperature_c));
  return solved;
}

/// A block that stands free and has cooled from its liquidus to this temperature at each height.
v1::Frame cooled(const std::function<double(double height_m)>& temperature_c) {
  v1::Frame frame;
  frame.set_time_s(1000.0);
  frame.set_cast_length_m(0.95);
  frame.set_dimension(3);
  frame.set_nodes_per_element(8);
  frame.set_liquidus_c(liquidus_c);
  frame.set_solidus_c(620.0);
  for (const double z : height_m)
    for (std::size_t i = 0; i < along_m.size(); ++i)
      for (const double share : {1.0, 0.4, 0.0}) {  // in no order
        frame.add_temperature_c(temperature_c(z));
        for (const double x : {along_m[i], share * opening_m[i], z}) {
          frame.add_node_m(x);
          frame.add_displacement_m(x * (stretch(temperature_c(z)) - 1.0));
        }
      }
  return frame;
}

double uniform(double) {
  return 320.0;
}

/// Hot metal in the last row.
double hot_above(double height) {
  return height > 0.3 ? 640.0 : 320.0;
}

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
  EXPECT_THROW(contraction_of(section, frame), CommandFailed);
  v1::Frame without_mechanics = frame;
  without_mechanics.clear_displacement_m();
  EXPECT_THROW(contraction_of(quarter_slab(), without_mechanics), CommandFailed);
  for (int n = 0; n < frame.temperature_c_size(); ++n) frame.set_node_m(3 * n + 2, 1e-3 * n);
  EXPECT_THROW(contraction_of(quarter_slab(), frame), CommandFailed) << "no two nodes are level";
}

struct ContractionCommand : testing::Test {
  FakeService service;
  void SetUp() override {
    service.job.set_id("job");
    service.job.set_state(v1::SUCCEEDED);
    *service.result.mutable_case_() = quarter_slab();
    *service.result.mutable_frame() = cooled(hot_above);
  }
  Result run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"contraction", "job"});
    return dccast(std::move(arguments), service.address());
  }
};

TEST_F(ContractionCommand, ShowsButtMiddleAndHead) {
  const Result result = run({});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("butt"));
  EXPECT_THAT(result.out, HasSubstr("head"));
  const double cold_mm = 300.0 * stretch(20.0);
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", cold_mm);
  EXPECT_THAT(result.out, HasSubstr(text));
}

TEST_F(ContractionCommand, ShowsTheHeightsAskedForAgainstWhatIsWanted) {
  const Result result = run({"--height", "210 mm", "--wanted", "0.29 m"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("200.0"));
  EXPECT_THAT(result.out, HasSubstr("over wanted"));
  const Result refused = run({"--wanted", "0.29"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--wanted \"0.29\""));
}

TEST_F(ContractionCommand, JsonHasAllRowsAndNullWhereNothingIsKnown) {
  const Json json = Json::parse(run({"--json"}).out);
  ASSERT_EQ(json["rows"].size(), height_m.size());
  EXPECT_EQ(json["rows"][0]["x_m"].size(), along_m.size());
  EXPECT_TRUE(json["rows"][3]["half_thickness_at_20_c_m"][0].is_null());
  EXPECT_FALSE(json["rows"][3]["solid"]);
}

}  // namespace
}  // namespace dccast::client
