#include "server/studies/study_evaluation.hpp"

#include <cmath>

#include "tests/unit/studies/studies_fixture.hpp"

namespace dccast::studies {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class StudyEvaluationTest : public StudiesTest {
protected:
  v1::StudyResult evaluated(const std::string& id, bool curves = false) {
    v1::EvaluateStudyRequest request;
    request.set_id(id);
    request.set_curves(curves);
    return evaluation_.evaluate(request).value();
  }
  /// A sweep of two runs, the first of which has ended.
  std::string half_done() {
    const std::string id = create(sweep(2));
    feeder_.feed(id);
    feeder_.feed(id);
    queue_.scheduler.start();
    run_next_job({step(1, 1e-3), step(2, 2e-3)});
    return id;
  }
};

TEST_F(StudyEvaluationTest, OfAnUnknownStudyIsNothing) {
  EXPECT_FALSE(evaluation_.evaluate({}));
}

TEST_F(StudyEvaluationTest, WaitingRunsAreQueuedAndHaveNoCurl) {
  const v1::StudyResult result = evaluated(create(sweep(2)));
  EXPECT_THAT(result.monitors(), ElementsAre("lip"));
  ASSERT_EQ(result.runs_size(), 2);
  for (const v1::StudyRun& run : result.runs()) {
    EXPECT_EQ(run.state(), v1::QUEUED);
    EXPECT_TRUE(std::isnan(run.end_curl_m(0)));
  }
}

TEST_F(StudyEvaluationTest, AnEndedRunHasItsCurlAndOnRequestItsCurve) {
  const std::string id = half_done();
  EXPECT_TRUE(evaluated(id).runs(0).curves().empty());

  const v1::StudyResult result = evaluated(id, true);
  const v1::StudyRun& run = result.runs(0);
  EXPECT_EQ(run.state(), v1::SUCCEEDED);
  EXPECT_EQ(run.end_curl_m(0), 2e-3);
  ASSERT_EQ(run.curves_size(), 1);
  EXPECT_THAT(run.curves(0).time_s(), ElementsAre(10.0, 20.0));
  EXPECT_THAT(run.curves(0).curl_m(), ElementsAre(1e-3, 2e-3));
  EXPECT_TRUE(result.runs(1).curves().empty());
  EXPECT_EQ(result.study().succeeded(), 1);
}

TEST_F(StudyEvaluationTest, ARunWhoseJobWasDeletedIsLeftOut) {
  const std::string id = half_done();
  queue_.scheduler.remove(runs(id)[0].job);
  const v1::StudyResult result = evaluated(id);
  ASSERT_EQ(result.runs_size(), 1);
  EXPECT_NE(result.runs(0).state(), v1::SUCCEEDED);
}

TEST_F(StudyEvaluationTest, APartThatCannotBeComputedLeavesItsReason) {
  v1::EvaluateStudyRequest request;
  request.set_id(create(sweep(8)));
  request.set_spread("lip");
  request.add_castings()->add_studies("unknown");
  const v1::StudyResult result = evaluation_.evaluate(request).value();
  EXPECT_THAT(result.spread_fault(), HasSubstr("valid runs that succeeded, and 0 have"));
  EXPECT_EQ(result.calibration_fault(), "there is no sweep unknown");
  EXPECT_EQ(result.runs_size(), 8);
}

}  // namespace
}  // namespace dccast::studies
