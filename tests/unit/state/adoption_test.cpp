#include "server/state/adoption.hpp"

#include "core/storage/file.hpp"
#include "tests/unit/state/state_folder_fixture.hpp"

namespace dccast::state {
namespace {

namespace fs = std::filesystem;

class AdoptionTest : public StateFolderTest {
protected:
  v1::Job adopted(const std::string& id) {
    adopt(*store_, folder_.jobs() / id);
    return store_->find(id)->job;
  }
};

TEST_F(AdoptionTest, MakesTheRowThatWasLost) {
  const std::string kept = add_job("one");
  const std::string lost = add_job("two", false);
  const v1::Job job = adopted(lost);
  v1::Job expected = store_->find(kept)->job;
  expected.set_id(lost);
  expected.set_request_id("two");
  EXPECT_EQ(job.SerializeAsString(), expected.SerializeAsString());
  EXPECT_EQ(store_->submitted_case(lost), store_->submitted_case(kept));
  EXPECT_EQ(store_->complete_case(lost), store_->complete_case(kept));
}

TEST_F(AdoptionTest, TakesStateTimesAttemptsAndEndFromTheLog) {
  const std::string failed = add_job("", false);
  const std::string succeeded = add_job("", false);
  for (const v1::JobState state : {v1::RUNNING, v1::QUEUED, v1::RUNNING}) {
    append_state(failed, state);
    append_state(succeeded, state);
  }
  append_state(failed, v1::FAILED);
  append_state(succeeded, v1::SUCCEEDED);
  const v1::Job of_failed = adopted(failed);
  EXPECT_EQ(of_failed.state(), v1::FAILED);
  EXPECT_EQ(of_failed.attempts(), 2);
  EXPECT_EQ(of_failed.failure().message(), "did not converge");
  EXPECT_TRUE(of_failed.has_start_time() && of_failed.has_end_time());
  const v1::Job of_succeeded = adopted(succeeded);
  EXPECT_EQ(of_succeeded.state(), v1::SUCCEEDED);
  EXPECT_EQ(of_succeeded.artifacts(0).name(), "results.h5");
}

TEST_F(AdoptionTest, RefusesWhatItCannotKnowWithTheReason) {
  const auto reason = [&](const std::string& id) -> std::string {
    try {
      adopt(*store_, folder_.jobs() / id);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  add_job("taken");
  EXPECT_NE(reason(add_job("taken", false)).find("belongs to job"), std::string::npos);
  const std::string old = add_job("", false);
  fs::remove(folder_.jobs() / old / jobs::description_file);
  EXPECT_NE(reason(old).find("earlier version"), std::string::npos);
  const std::string renamed = values::random_uuid();
  fs::rename(folder_.jobs() / add_job("", false), folder_.jobs() / renamed);
  EXPECT_NE(reason(renamed).find("another job"), std::string::npos);
  const std::string silent = add_job("", false);
  fs::remove(folder_.jobs() / silent / "events.log");
  storage::create_durably(folder_.jobs() / silent / "results.h5", "results");
  EXPECT_NE(reason(silent).find("events.log is lost"), std::string::npos);
  EXPECT_EQ(store_->ids().size(), 1u);
}

}  // namespace
}  // namespace dccast::state
