#include "server/state/store_guard.hpp"

#include <sstream>

#include "core/storage/file.hpp"
#include "server/state/check.hpp"
#include "tests/unit/state/state_folder_fixture.hpp"

namespace dccast::state {
namespace {

namespace fs = std::filesystem;

class StoreGuardTest : public StateFolderTest {};

TEST_F(StoreGuardTest, TakesAnEmptyFolderAndOneThatIsWhole) {
  store_.reset();
  fs::remove(folder_.store());
  EXPECT_TRUE(open_store(folder_)->ids().empty());
  store_ = std::make_unique<jobs::JobStore>(folder_.store());
  const std::string id = add_job();
  store_.reset();
  EXPECT_EQ(open_store(folder_)->ids(), std::set<std::string>{id});
}

// A submission that was cut short before its answer is no loss; one that was answered is.
TEST_F(StoreGuardTest, TellsALostJobFromOneThatWasNeverAcknowledged) {
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
TEST_F(StoreGuardTest, MarksWaitingJobsAsAccepted) {
  const std::string id = add_job();
  fs::remove(folder_.jobs() / id / "accepted");
  store_.reset();
  open_store(folder_);
  EXPECT_TRUE(jobs::was_accepted(folder_.jobs() / id));
}

// The folders are the truth, the store is an index of them.
TEST_F(StoreGuardTest, AStoreThatIsMissingIsBuiltAgain) {
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
  EXPECT_EQ(store->complete_case(waiting), std::string(9000, 'c'));
}

TEST_F(StoreGuardTest, AStoreWithADamagedPageIsBuiltAgainAndKeptAside) {
  for (int i = 0; i < 20; ++i) add_job();
  const auto ids = store_->ids();
  store_.reset();
  std::string bytes = storage::read_file(folder_.store());
  for (std::size_t at = 8192; at < 8192 + 512; ++at) bytes[at] = 'x';
  storage::replace_file(folder_.store(), bytes);
  EXPECT_EQ(open_store(folder_)->ids(), ids);
  EXPECT_TRUE(fs::exists(folder_.quarantine() / "store" / "jobs.sqlite"));
}

// SQLite has no checksum over what a row holds: a flipped bit there would run another case.
TEST_F(StoreGuardTest, ARowThatHoldsAnotherCaseIsMadeAgain) {
  const std::string id = add_job();
  store_.reset();
  std::string bytes = storage::read_file(folder_.store());
  const auto at = bytes.find(std::string(40, 'c'));
  ASSERT_NE(at, std::string::npos);
  bytes[at + 20] ^= 1;
  storage::replace_file(folder_.store(), bytes);
  std::ostringstream said;
  EXPECT_EQ(check(folder_, {}, said), 1) << said.str();
  EXPECT_EQ(open_store(folder_)->complete_case(id), std::string(9000, 'c'));
}

// A worker reads its case there.
TEST_F(StoreGuardTest, ADescriptionThatCannotBeReadIsWrittenAgain) {
  const std::string id = add_job();
  store_.reset();
  storage::replace_file(folder_.jobs() / id / jobs::description_file, "damaged");
  open_store(folder_);
  EXPECT_EQ(jobs::read_job_description(folder_.jobs() / id).complete_case, std::string(9000, 'c'));
}

// A run that goes on in its folder, whatever the store says.
TEST_F(StoreGuardTest, ARowThatHasEndedFollowsAClaimedFolder) {
  const std::string id = add_job();
  append_state(id, v1::RUNNING);
  storage::write_file(folder_.jobs() / id / "worker.lock", "2 1 " + id + "\n");
  auto record = *store_->find(id);
  record.job.set_state(v1::CANCELLED);
  store_->update(record, jobs::Durability::full);
  store_.reset();
  EXPECT_EQ(open_store(folder_)->find(id)->job.state(), v1::RUNNING);
}

TEST_F(StoreGuardTest, HundredsOfJobsAreFoundAgain) {
  constexpr int count = 300;
  for (int i = 0; i < count; ++i) add_job("", false);
  store_.reset();
  fs::remove(folder_.store());
  EXPECT_EQ(open_store(folder_)->ids().size(), std::size_t{count});
}

}  // namespace
}  // namespace dccast::state
