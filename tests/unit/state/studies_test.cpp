#include "server/studies/study_store.hpp"

#include "core/storage/file.hpp"
#include "server/state/index.hpp"
#include "server/studies/studies.hpp"
#include "tests/unit/state/state_folder_fixture.hpp"

namespace dccast::state {
namespace {

namespace fs = std::filesystem;
using studies::RunRecord;

/// A study of two levels in a folder whose index is lost.
class LostIndex : public StateFolderTest {
protected:
  void SetUp() override {
    StateFolderTest::SetUp();
    fs::create_directories(folder_.studies());
    study_.id = "0d6c3a52-8f5e-4c1b-9f4e-2a7b1c3d5e6f";
    study_.created_ms = study_.changed_ms = 1000;
    study_.case_sha256 = "ab12";
    study_.request.mutable_refinement()->set_levels(2);
    studies::write_study_file(folder_.studies(), study_);
  }
  std::vector<RunRecord> runs_of_rebuilt_index() {
    store_.reset();
    fs::remove(folder_.store());
    open_store(folder_);
    return studies::StudyStore(folder_.store()).runs(study_.id);
  }
  static RunRecord cancelled(int number, int attempt = 0) {
    return {
        .number = number, .attempt = attempt, .job = "", .outcome = v1::CANCELLED, .failure = {}};
  }

  studies::StudyRecord study_;
};

TEST_F(LostIndex, WaitingRunsOfAStudyAreQueued) {
  for (const RunRecord& run : runs_of_rebuilt_index()) EXPECT_TRUE(run.to_queue());
}

// They were, and a sweep that its user had cancelled was computed after all.
TEST_F(LostIndex, CancelledAndRefusedRunsAreNotQueuedAgain) {
  RunRecord refused{.number = 1, .attempt = 0, .job = "", .outcome = v1::FAILED, .failure = {}};
  refused.failure.set_message("no such key");
  studies::append_runs(folder_.studies(), study_.id, {cancelled(0), refused});
  const auto runs = runs_of_rebuilt_index();
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].outcome, v1::CANCELLED);
  EXPECT_EQ(runs[1].outcome, v1::FAILED);
  EXPECT_EQ(runs[1].failure.message(), "no such key");
}

TEST_F(LostIndex, ARunThatWasResumedWaits) {
  studies::append_runs(folder_.studies(), study_.id, {cancelled(0), cancelled(1)});
  studies::append_runs(folder_.studies(), study_.id, {{.number = 1, .failure = {}}});
  const auto runs = runs_of_rebuilt_index();
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_FALSE(runs[0].to_queue());
  EXPECT_TRUE(runs[1].to_queue());
}

TEST_F(LostIndex, AJobThatWasMadeLaterStandsForItsRun) {
  studies::append_runs(folder_.studies(), study_.id, {cancelled(0)});
  const std::string job =
      add_job(studies::job_request_id(study_.id, studies::study_plan(study_.request)->key(0), 1));
  const auto runs = runs_of_rebuilt_index();
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].job, job);
}

TEST_F(LostIndex, ARecordThatACrashCutShortIsNotReadAndNotInTheWay) {
  const auto path = studies::study_file(folder_.studies(), study_.id);
  studies::append_runs(folder_.studies(), study_.id, {cancelled(0)});
  const std::string whole = storage::read_file(path);
  storage::write_file(path, whole + whole.substr(whole.size() - 20, 15));
  EXPECT_EQ(studies::read_study_runs(folder_.studies(), study_.id).size(), 1u);
  studies::append_runs(folder_.studies(), study_.id, {cancelled(1)});
  EXPECT_EQ(studies::read_study_runs(folder_.studies(), study_.id).size(), 2u);
  study_.request.mutable_refinement()->set_levels(3);
  studies::write_study_file(folder_.studies(), study_);
  EXPECT_EQ(studies::read_study_runs(folder_.studies(), study_.id).size(), 2u) << "they are kept";
}

}  // namespace
}  // namespace dccast::state
