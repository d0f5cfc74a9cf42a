#include "server/state/store_guard.hpp"

#include <sstream>

#include "core/storage/durable_file.hpp"
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
  EXPECT_THROW(open_store(folder_), StoreLost);
}

// A crash between the row and the mark: who asks again with the same request_id is told of the job.
TEST_F(StoreGuardTest, MarksWaitingJobsAsAccepted) {
  const std::string id = add_job();
  fs::remove(folder_.jobs() / id / "accepted");
  store_.reset();
  open_store(folder_);
  EXPECT_TRUE(jobs::was_accepted(folder_.jobs() / id));
}

TEST_F(StoreGuardTest, RefusesADamagedPageWithTheRemedy) {
  for (int i = 0; i < 20; ++i) add_job();
  store_.reset();
  std::string bytes = storage::read_file(folder_.store());
  for (std::size_t at = 8192; at < 8192 + 512; ++at) bytes[at] = 'x';
  storage::replace_file(folder_.store(), bytes);
  try {
    open_store(folder_);
    FAIL() << "it was taken";
  } catch (const StoreLost& error) {
    EXPECT_NE(std::string(error.what()).find("dccastd check --repair"), std::string::npos);
    EXPECT_EQ(std::string(error.what()).find("SELECT"), std::string::npos) << error.what();
  }
}

// SQLite has no checksum over what a row holds: a flipped bit there would run another case.
TEST_F(StoreGuardTest, RefusesARowThatHoldsAnotherCase) {
  const std::string id = add_job();
  store_.reset();
  std::string bytes = storage::read_file(folder_.store());
  const auto at = bytes.find(std::string(40, 'c'));
  ASSERT_NE(at, std::string::npos);
  bytes[at + 20] ^= 1;
  storage::replace_file(folder_.store(), bytes);
  EXPECT_THROW(open_store(folder_), StoreLost);
  std::ostringstream said;
  EXPECT_EQ(check(folder_, {}, said), 1) << said.str();
  EXPECT_EQ(check(folder_, {.repair = true, .deep = false, .adopt = {}}, said), 0) << said.str();
  EXPECT_EQ(open_store(folder_)->complete_case(id), std::string(9000, 'c'));
}

}  // namespace
}  // namespace dccast::state
