#include "server/state/index.hpp"

#include <sstream>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/state/check.hpp"
#include "tests/unit/state/state_folder_fixture.hpp"

namespace dccast::state {
namespace {

namespace fs = std::filesystem;

class IndexTest : public StateFolderTest {
protected:
  v1::Job indexed(const std::string& id) {
    index_job(*store_, folder_.jobs() / id);
    return store_->find(id)->job;
  }
};

TEST_F(IndexTest, TakesAnEmptyFolderAndOneThatIsWhole) {
  store_.reset();
  fs::remove(folder_.store());
  EXPECT_TRUE(open_store(folder_)->ids().empty());
  store_ = std::make_unique<jobs::JobStore>(folder_.store());
  const std::string id = add_job();
  store_.reset();
  EXPECT_EQ(open_store(folder_)->ids(), std::set<std::string>{id});
}

// A submission that was cut short before its answer is no loss; one that was answered is.
TEST_F(IndexTest, TellsALostJobFromOneThatWasNeverAcknowledged) {
  add_job();
  const std::string other = add_job("", false);
  fs::remove(folder_.jobs() / other / "accepted");
  store_.reset();
  EXPECT_TRUE(lost_jobs(folder_, open_store(folder_)->ids()).empty());
  append_state(other, v1::RUNNING);
  EXPECT_EQ(lost_jobs(folder_, jobs::JobStore(folder_.store()).ids()),
            std::set<std::string>{other});
  EXPECT_TRUE(open_store(folder_)->find(other));
}

// A crash between the row and the mark: who asks again with the same request_id is told of the job.
TEST_F(IndexTest, MarksWaitingJobsAsAccepted) {
  const std::string id = add_job();
  fs::remove(folder_.jobs() / id / "accepted");
  store_.reset();
  open_store(folder_);
  EXPECT_TRUE(jobs::was_accepted(folder_.jobs() / id));
}

// The folders are the truth, the store is an index of them.
TEST_F(IndexTest, AStoreThatIsMissingIsBuiltAgain) {
  const std::string id = add_job("mine");
  append_state(id, v1::RUNNING);
  append_state(id, v1::SUCCEEDED);
  const std::string waiting = add_job();
  store_.reset();
  fs::remove(folder_.store());
  const auto store = open_store(folder_);
  EXPECT_EQ(store->ids(), (std::set<std::string>{id, waiting}));
  EXPECT_EQ(store->find_request("mine")->job.state(), v1::SUCCEEDED);
  EXPECT_EQ(store->find(id)->job.artifacts(0).name(), "results.h5");
}

TEST_F(IndexTest, ACheckReportsAMissingStoreAndMakesNone) {
  add_job();
  store_.reset();
  fs::remove(folder_.store());
  std::ostringstream report;
  EXPECT_EQ(check(folder_, {}, report), 1) << report.str();
  EXPECT_FALSE(fs::exists(folder_.store()));
}

TEST_F(IndexTest, AStoreWithADamagedPageIsBuiltAgainAndKeptAside) {
  for (int i = 0; i < 20; ++i) add_job();
  const auto ids = store_->ids();
  store_.reset();
  std::string bytes = storage::read_file(folder_.store());
  for (std::size_t at = 8192; at < 8192 + 512; ++at) bytes[at] = 'x';
  storage::replace_file(folder_.store(), bytes);
  EXPECT_EQ(open_store(folder_)->ids(), ids);
  EXPECT_TRUE(fs::exists(folder_.quarantine() / "store" / "jobs.sqlite"));
}

// SQLite has no checksum over what a row holds; the job in it has one.
TEST_F(IndexTest, ADamagedRowIsMadeAgain) {
  const std::string id = add_job();
  store_.reset();
  std::string bytes = storage::read_file(folder_.store());
  const auto at = bytes.rfind("a casting");
  ASSERT_NE(at, std::string::npos);
  bytes[at + 2] ^= 1;
  storage::replace_file(folder_.store(), bytes);
  std::ostringstream said;
  EXPECT_EQ(check(folder_, {}, said), 1) << said.str();
  EXPECT_EQ(open_store(folder_)->find(id)->job.title(), "a casting");
  EXPECT_EQ(check(folder_, {}, said), 0) << said.str();
}

TEST_F(IndexTest, AnAttachmentThatIsDamagedIsReported) {
  jobs::JobDescription job = description("");
  const fs::path uploaded = folder_.path() / "uploaded";
  storage::write_file(uploaded, "abc");
  const jobs::Attachments attachments{
      {.name = "mesh", .sha256 = values::sha256("abc"), .bytes = 3, .path = uploaded}};
  const fs::path of_job = folder_.jobs() / job.job.id();
  jobs::create_job_folder(of_job, attachments, job);
  append_state(job.job.id(), v1::QUEUED);
  index_job(*store_, of_job);
  std::ostringstream said;
  EXPECT_EQ(check(folder_, {.deep = true}, said), 0) << said.str();

  storage::replace_file(of_job / jobs::attachments_folder / "mesh", "abd");
  EXPECT_EQ(check(folder_, {.deep = true}, said), 1) << said.str();
}

// A run that goes on in its folder, whatever the store says.
TEST_F(IndexTest, ARowThatHasEndedFollowsAClaimedFolder) {
  const std::string id = add_job();
  append_state(id, v1::RUNNING);
  storage::write_file(folder_.jobs() / id / "worker.lock", "2 1 " + id + "\n");
  auto record = *store_->find(id);
  record.job.set_state(v1::CANCELLED);
  store_->put(record);
  store_.reset();
  EXPECT_EQ(open_store(folder_)->find(id)->job.state(), v1::RUNNING);
}

TEST_F(IndexTest, HundredsOfJobsAreFoundAgain) {
  constexpr int count = 300;
  for (int i = 0; i < count; ++i) add_job("", false);
  store_.reset();
  fs::remove(folder_.store());
  EXPECT_EQ(open_store(folder_)->ids().size(), std::size_t{count});
}

TEST_F(IndexTest, MakesTheRowThatWasLost) {
  const std::string kept = add_job("one");
  const std::string lost = add_job("two", false);
  const v1::Job job = indexed(lost);
  v1::Job expected = store_->find(kept)->job;
  expected.set_id(lost);
  expected.set_request_id("two");
  EXPECT_EQ(job.SerializeAsString(), expected.SerializeAsString());
}

TEST_F(IndexTest, TakesStateTimesAttemptsAndEndFromTheLog) {
  const std::string failed = add_job("", false);
  const std::string succeeded = add_job("", false);
  for (const v1::JobState state : {v1::RUNNING, v1::QUEUED, v1::RUNNING}) {
    append_state(failed, state);
    append_state(succeeded, state);
  }
  append_state(failed, v1::FAILED);
  append_state(succeeded, v1::SUCCEEDED);
  const v1::Job of_failed = indexed(failed);

  EXPECT_EQ(of_failed.state(), v1::FAILED);
  EXPECT_EQ(of_failed.attempts(), 2);
  EXPECT_EQ(of_failed.failure().message(), "did not converge");
  EXPECT_TRUE(of_failed.has_start_time() && of_failed.has_end_time());

  const v1::Job of_succeeded = indexed(succeeded);
  EXPECT_EQ(of_succeeded.state(), v1::SUCCEEDED);
  EXPECT_EQ(of_succeeded.artifacts(0).name(), "results.h5");
}

TEST_F(IndexTest, RefusesWhatItCannotKnowWithTheReason) {
  const auto reason = [&](const std::string& id) -> std::string {
    try {
      index_job(*store_, folder_.jobs() / id);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  add_job("taken");
  EXPECT_NE(reason(add_job("taken", false)).find("belongs to job"), std::string::npos);

  const std::string old = add_job("", false);
  fs::remove(folder_.jobs() / old / jobs::description_file);
  EXPECT_NE(reason(old).find("no description.bin"), std::string::npos);

  const std::string renamed = values::random_uuid();
  fs::rename(folder_.jobs() / add_job("", false), folder_.jobs() / renamed);
  EXPECT_NE(reason(renamed).find("another job"), std::string::npos);

  const std::string silent = add_job("", false);
  fs::remove(folder_.jobs() / silent / "events.log");
  storage::create_durably(folder_.jobs() / silent / "results.h5", "results");
  EXPECT_NE(reason(silent).find("events.log is lost"), std::string::npos);
  EXPECT_EQ(store_->ids().size(), 1u);
}

TEST_F(IndexTest, ALogThatIsDamagedFromItsBeginningIsThatOfAWaitingJobUnlessItHasRun) {
  const std::string waiting = add_job("", false), has_run = add_job("", false);
  for (const std::string& id : {waiting, has_run})
    storage::write_file(folder_.jobs() / id / "events.log", std::string(60, 'x'));
  storage::create_durably(folder_.jobs() / has_run / "worker.log", "started\n");

  index_job(*store_, folder_.jobs() / waiting);
  EXPECT_EQ(store_->find(waiting)->job.state(), v1::QUEUED);
  EXPECT_THROW(index_job(*store_, folder_.jobs() / has_run), std::runtime_error);
}

}  // namespace
}  // namespace dccast::state
