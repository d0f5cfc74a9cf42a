#include "server/studies/study_requests.hpp"

#include "tests/unit/studies/studies_fixture.hpp"

namespace dccast::studies {
namespace {

using Kind = StudyReply::Kind;

class StudyRequestsTest : public StudiesTest {
protected:
  /// A study one of whose two runs was refused; the other one is cancelled.
  std::string refused_and_cancelled() {
    const std::string id = create(sweep(2));
    v1::Finding failure;
    failure.set_kind(v1::Finding::INVALID_CASE);
    failure.set_message("no such key");
    store_.refuse(id, 0, failure, 1000);
    requests_.cancel(id, "not needed");
    return id;
  }
};

TEST_F(StudyRequestsTest, ANewStudyHasRowAndFileAndWaitingRuns) {
  const v1::Study study = requests_.create(sweep(2), {}, owner);
  EXPECT_EQ(study.state(), v1::STUDY_RUNNING);
  EXPECT_EQ(study.title(), "a casting");
  EXPECT_EQ(study.queued(), 2);
  EXPECT_EQ(study.progress(), 0.0);
  EXPECT_EQ(store_.find(study.id())->owner, owner);
  EXPECT_EQ(read_study_file(options_.directory, study.id()).request.sweep().runs(), 2);
}

TEST_F(StudyRequestsTest, ARepeatedRequestCreatesNothing) {
  const std::string id = create(sweep(2, "r"));
  EXPECT_EQ(create(sweep(2, "r")), id);

  auto other_title = sweep(2, "r");
  other_title.mutable_case_()->set_title("another title");
  EXPECT_EQ(create(other_title), id) << "a title does not make another casting";
  EXPECT_EQ(requests_.list({}).size(), 1u);
}

TEST_F(StudyRequestsTest, ARequestIdIsOfOnePlanOneCaseAndOneUser) {
  create(sweep(2, "r"));
  auto other_case = sweep(2, "r");
  other_case.mutable_case_()->mutable_time()->set_end_s(146);
  EXPECT_THROW(create(sweep(3, "r")), jobs::RequestIdTaken);
  EXPECT_THROW(create(other_case), jobs::RequestIdTaken);
  EXPECT_THROW(requests_.create(sweep(2, "r"), {}, "someone else"), jobs::RequestIdTaken);
  EXPECT_EQ(requests_.list({}).size(), 1u);
}

TEST_F(StudyRequestsTest, ARefinementIsContinuedToFinerLevels) {
  const std::string id = create(refinement(2, "r"));
  EXPECT_EQ(create(refinement(4, "r")), id);
  EXPECT_EQ(runs(id).size(), 4u);
  EXPECT_EQ(read_study_file(options_.directory, id).request.refinement().levels(), 4);
  EXPECT_EQ(state_.plan_of(*store_.find(id))->runs(), 4);

  create(refinement(3, "r"));
  EXPECT_EQ(runs(id).size(), 4u) << "levels are never removed";
}

TEST_F(StudyRequestsTest, FurtherRunsTakeTheCaseOfTheirStudy) {
  v1::CreateStudyRequest further;
  further.mutable_sweep()->set_further_of(create(sweep(2)));
  ASSERT_TRUE(requests_.complete(further));
  EXPECT_EQ(further.case_().title(), "a casting");

  further.mutable_sweep()->set_further_of("unknown");
  EXPECT_FALSE(requests_.complete(further));
}

TEST_F(StudyRequestsTest, CancellationEndsWaitingRunsAndIsInTheFile) {
  const std::string id = create(sweep(2));
  const StudyReply reply = requests_.cancel(id, "not needed");
  EXPECT_EQ(reply.kind, Kind::done);
  EXPECT_EQ(reply.study.state(), v1::STUDY_CANCELLED);
  EXPECT_EQ(reply.study.message(), "2 of 2 runs were cancelled");
  EXPECT_TRUE(reply.study.has_end_time());
  for (const auto& [number, run] : read_study_runs(options_.directory, id))
    EXPECT_EQ(run.outcome, v1::CANCELLED);
  EXPECT_EQ(requests_.cancel("unknown", "").kind, Kind::not_found);
}

TEST_F(StudyRequestsTest, CancellationReachesTheJobsOfTheOwner) {
  const std::string id = create(sweep(2));
  feeder_.feed(id);
  requests_.cancel(id, "not needed");
  queue_.scheduler.start();
  EXPECT_TRUE(becomes(queue_, runs(id)[0].job, v1::CANCELLED));
  EXPECT_EQ(found(id).state(), v1::STUDY_CANCELLED);
}

TEST_F(StudyRequestsTest, ResumptionQueuesCancelledRuns) {
  const std::string id = refused_and_cancelled();
  EXPECT_EQ(requests_.resume(id, false).study.state(), v1::STUDY_RUNNING);
  EXPECT_FALSE(runs(id)[0].to_queue()) << "the same case would be refused again";
  EXPECT_TRUE(runs(id)[1].to_queue());
}

TEST_F(StudyRequestsTest, ResumptionOfFailedRunsIncludesRefusedOnes) {
  const std::string id = refused_and_cancelled();
  requests_.resume(id, true);
  for (const RunRecord& run : runs(id)) EXPECT_TRUE(run.to_queue());
}

TEST_F(StudyRequestsTest, OnlyAnEndedStudyIsRemoved) {
  const std::string id = create(sweep(2));
  EXPECT_EQ(requests_.remove(id).kind, Kind::wrong_state);
  requests_.cancel(id, "not needed");
  EXPECT_EQ(requests_.remove(id).kind, Kind::done);
  EXPECT_FALSE(requests_.find(id));
  EXPECT_TRUE(ids_of_study_files(options_.directory).empty());
  EXPECT_EQ(requests_.remove(id).kind, Kind::not_found);
}

TEST_F(StudyRequestsTest, RemovalTakesTheJobs) {
  const std::string id = create(sweep(1));
  feeder_.feed(id);
  const std::string job = runs(id)[0].job;
  queue_.scheduler.start();
  run_next_job({step(1, 1e-3)});
  ASSERT_EQ(requests_.remove(id).kind, Kind::done);
  EXPECT_FALSE(queue_.scheduler.find(job));
}

TEST_F(StudyRequestsTest, ARunWhoseJobWasDeletedIsQueuedByTheSameRequest) {
  const std::string id = create(sweep(1, "r"));
  feeder_.feed(id);
  requests_.cancel(id, "not needed");
  queue_.scheduler.start();
  ASSERT_TRUE(becomes(queue_, runs(id)[0].job, v1::CANCELLED));
  queue_.scheduler.remove(runs(id)[0].job);
  EXPECT_EQ(found(id).message(), "all jobs of the study were deleted");

  requests_.resume(id, true);
  EXPECT_FALSE(runs(id)[0].to_queue()) << "it was deleted on purpose";
  create(sweep(1, "r"));
  EXPECT_TRUE(runs(id)[0].to_queue());
}

TEST_F(StudyRequestsTest, RecoveryWritesMissingFilesAndEndsRemovals) {
  const std::string kept = create(sweep(2)), removed = create(sweep(3));
  remove_study_file(options_.directory, kept);
  store_.begin_removal(removed);
  requests_.recover();
  EXPECT_EQ(ids_of_study_files(options_.directory), std::set{kept});
  EXPECT_TRUE(store_.removing().empty());
}

}  // namespace
}  // namespace dccast::studies
