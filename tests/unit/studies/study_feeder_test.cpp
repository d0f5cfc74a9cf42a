#include "server/studies/study_feeder.hpp"

#include "tests/unit/studies/studies_fixture.hpp"

namespace dccast::studies {
namespace {

using testing::HasSubstr;

class StudyFeederTest : public StudiesTest {
protected:
  using StudiesTest::StudiesTest;

  v1::Job job_of(const std::string& study, int run) {
    return queue_.scheduler.find(runs(study)[run].job).value();
  }
  /// Quarter slab whose mould is to be designed.
  static v1::CreateStudyRequest mould_design() {
    v1::CreateStudyRequest request;
    v1::Section& section = *request.mutable_case_()->mutable_section();
    section.set_kind(v1::Section::QUARTER_SLAB);
    section.set_half_width_m(0.66);
    section.set_initial_depth_m(0.066);
    section.mutable_half_thickness_m()->set_abscissa(v1::DISTANCE);
    for (const double at_m : {0.0, 0.66}) {
      section.mutable_half_thickness_m()->add_at(at_m);
      section.mutable_half_thickness_m()->add_value(0.3);
    }
    request.mutable_case_()->mutable_time()->set_end_s(600.0);
    request.mutable_mould()->set_tolerance_m(0.5e-3);
    request.mutable_mould()->set_wanted_half_thickness_m(0.285);
    return request;
  }
};

class CrashingChecks : public StudyFeederTest {
protected:
  CrashingChecks() : StudyFeederTest(crashes) {}
};

TEST_F(StudyFeederTest, MakesOneJobOfARunThatBelongsToTheOwnerOfTheStudy) {
  auto request = sweep(2);
  request.add_labels("trial");
  const std::string id = create(request);
  EXPECT_TRUE(feeder_.feed(id));

  const v1::Job job = job_of(id, 0);
  EXPECT_EQ(job.owner(), owner);
  EXPECT_EQ(job.study(), id);
  EXPECT_EQ(job.priority(), v1::LOW) << "a study does not delay a query";
  EXPECT_EQ(job.labels(0), "trial");
  EXPECT_EQ(job.changes(0).key(), "schedule.casting_speed");
  EXPECT_TRUE(runs(id)[1].to_queue());
}

TEST_F(StudyFeederTest, StopsWhenEveryRunHasAJob) {
  const std::string id = create(sweep(2));
  EXPECT_TRUE(feeder_.feed(id));
  EXPECT_TRUE(feeder_.feed(id));
  EXPECT_FALSE(feeder_.feed(id));
  EXPECT_FALSE(feeder_.feed("unknown"));
}

// After a crash between the job and its row the run is fed again.
TEST_F(StudyFeederTest, ARunThatIsFedAgainHasTheSameJob) {
  const std::string id = create(sweep(1));
  feeder_.feed(id);
  const std::string job = runs(id)[0].job;
  const StudyRecord record = *store_.find(id);
  store_.erase(id);
  store_.insert(record, {{.number = 0, .failure = {}}});
  feeder_.feed(id);
  EXPECT_EQ(runs(id)[0].job, job);
  EXPECT_EQ(queue_.scheduler.queued(), 1);
}

TEST_F(StudyFeederTest, ARunIsNotQueuedInAFullQueueAndStaysWaiting) {
  const std::string id = create(sweep(3));
  feeder_.feed(id);
  feeder_.feed(id);
  EXPECT_ANY_THROW(feeder_.feed(id));
  EXPECT_TRUE(runs(id)[2].to_queue());
}

TEST_F(StudyFeederTest, ThreadQueuesRunsAsTheQueueTakesThem) {
  feeder_.start();
  const std::string id = create(sweep(2));
  EXPECT_TRUE(eventually([&] { return queue_.scheduler.queued() == 2; }));
  feeder_.stop();
  EXPECT_EQ(found(id).queued(), 2);
}

TEST_F(StudyFeederTest, ARunWhoseCaseHasFaultsFailsWithoutAJob) {
  auto request = sweep(1);
  request.mutable_case_()->mutable_time()->set_minimum_step_s(-1.0);
  const std::string id = create(request);
  EXPECT_TRUE(feeder_.feed(id));
  EXPECT_TRUE(runs(id)[0].job.empty());
  EXPECT_EQ(runs(id)[0].outcome, v1::FAILED);
  EXPECT_THAT(runs(id)[0].failure.message(), HasSubstr("is refused: time.minimum_step"));
  EXPECT_EQ(read_study_runs(options_.directory, id).at(0).outcome, v1::FAILED);
  EXPECT_EQ(found(id).state(), v1::STUDY_FAILED);
}

TEST_F(CrashingChecks, RefuseARunAtTheThird) {
  const std::string id = create(sweep(2));
  for (int check = 0; check < 2; ++check) {
    EXPECT_TRUE(feeder_.feed(id));
    EXPECT_TRUE(runs(id)[0].to_queue());
  }
  EXPECT_TRUE(feeder_.feed(id));
  EXPECT_EQ(runs(id)[0].outcome, v1::FAILED);
  EXPECT_TRUE(runs(id)[1].to_queue()) << "its own checks are counted";
}

TEST_F(StudyFeederTest, TheNextRunOfAGrowingPlanWaitsForTheEndOfTheOneBefore) {
  const std::string id = create(mould_design());
  ASSERT_TRUE(feeder_.feed(id));
  ASSERT_EQ(runs(id).size(), 2u) << "the study does not end between two runs";
  EXPECT_FALSE(feeder_.feed(id));
  EXPECT_TRUE(runs(id)[1].to_queue());
}

TEST_F(StudyFeederTest, APlanEndsWithARunThatFailed) {
  const std::string id = create(mould_design());
  feeder_.feed(id);
  queue_.scheduler.start();
  run_next_job({}, v1::RunEnd::FAILED);
  EXPECT_TRUE(feeder_.feed(id));
  EXPECT_EQ(runs(id).size(), 1u);
  EXPECT_EQ(found(id).state(), v1::STUDY_FAILED);
}

TEST_F(StudyFeederTest, ARunIsRefusedIfTheFaceBeforeItCannotBeRead) {
  const std::string id = create(mould_design());
  feeder_.feed(id);
  queue_.scheduler.start();
  run_next_job({});
  EXPECT_TRUE(feeder_.feed(id));
  EXPECT_THAT(found(id).message(), HasSubstr("the face of job " + runs(id)[0].job));
  EXPECT_THAT(found(id).message(), HasSubstr("has no results.h5; run it again"));
}

}  // namespace
}  // namespace dccast::studies
