#include "server/studies/sweep_surfaces.hpp"

#include "tests/unit/studies/studies_fixture.hpp"

namespace dccast::studies {
namespace {

using testing::HasSubstr;

constexpr int runs_of_sweep = 6;

class SweepSurfacesTest : public StudiesTest {
protected:
  static v1::PredictStudyRequest at_speed(const std::string& study, const std::string& speed) {
    v1::PredictStudyRequest request;
    request.set_id(study);
    v1::CaseChange& value = *request.add_values();
    value.set_key("schedule.casting_speed");
    value.set_value(speed);
    return request;
  }
  /// A sweep over 40 to 60 mm/min whose curl is a hundredth of the speed's millimetres.
  std::string ended_sweep() {
    const std::string id = create(sweep(runs_of_sweep));
    queue_.scheduler.start();
    for (int run = 0; run < runs_of_sweep; ++run) {
      feeder_.feed(id);
      v1::StudyRun values;
      state_.plan_of(*store_.find(id))->describe(run, values);
      const double curl_m = 1e-5 * std::stod(values.values(0));
      run_next_job({step(1, 0.5 * curl_m), step(2, curl_m)});
    }
    return id;
  }
};

TEST_F(SweepSurfacesTest, PredictBetweenTheRunsOfASweep) {
  const std::string id = ended_sweep();
  const v1::Prediction prediction = surfaces_.predict(at_speed(id, "50 mm/min")).value();
  EXPECT_EQ(prediction.runs(), runs_of_sweep);
  ASSERT_EQ(prediction.curves_size(), 1);
  EXPECT_NEAR(prediction.curves(0).curl_m(1), 50e-5, 1e-5);
  EXPECT_THROW(surfaces_.predict(at_speed(id, "90 mm/min")), OutsideDomain);
}

TEST_F(SweepSurfacesTest, OfTooFewRunsThrowTheReason) {
  const std::string id = create(sweep(runs_of_sweep));
  EXPECT_THROW(surfaces_.predict(at_speed(id, "50 mm/min")), CannotPredict);
  EXPECT_THROW(surfaces_.spread(*store_.find(id), "lip"), CannotPredict);
  EXPECT_NO_THROW(surfaces_.prepare(id));
}

TEST_F(SweepSurfacesTest, AreOfSweepsThatAreThere) {
  EXPECT_FALSE(surfaces_.predict(at_speed("unknown", "50 mm/min")));
  EXPECT_THROW(surfaces_.predict(at_speed(create(refinement(2, "r")), "50 mm/min")), CannotPredict);
}

// A removed study's id may be used again, by the same request.
TEST_F(SweepSurfacesTest, ARemovedStudyIsForgotten) {
  const std::string id = ended_sweep();
  ASSERT_TRUE(surfaces_.predict(at_speed(id, "50 mm/min")));
  ASSERT_EQ(requests_.remove(id).kind, StudyReply::Kind::done);
  EXPECT_FALSE(surfaces_.predict(at_speed(id, "50 mm/min")));
}

TEST_F(SweepSurfacesTest, SpreadCoversTheCurlsOfTheRange) {
  const std::string id = ended_sweep();
  const v1::Spread spread = surfaces_.spread(*store_.find(id), "lip");
  ASSERT_EQ(spread.time_s_size(), 2);
  EXPECT_NEAR(spread.median_m(1), 50e-5, 1e-5);
  EXPECT_GT(spread.low_m(1), 39e-5);
  EXPECT_LT(spread.high_m(1), 61e-5);
}

}  // namespace
}  // namespace dccast::studies
