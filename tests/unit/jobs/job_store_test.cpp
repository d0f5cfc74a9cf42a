#include "server/jobs/job_store.hpp"

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include "server/jobs/events.hpp"
#include "server/jobs/identifier.hpp"
#include "tests/unit/jobs/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

JobRecord new_record(const std::string& request_id = "", std::int64_t created_ms = 1700000000123) {
  JobRecord record;
  record.job.set_id(random_uuid());
  record.job.set_title("a \"title\"; with 'quotes'");
  record.job.set_request_id(request_id);
  record.job.set_case_sha256("abc");
  record.job.set_state(v1::QUEUED);
  record.job.set_priority(v1::HIGH);
  *record.job.mutable_create_time() = timestamp(created_ms);
  return record;
}

bool same(const v1::Job& a, const v1::Job& b) {
  return google::protobuf::util::MessageDifferencer::Equals(a, b);
}

class JobStoreTest : public testing::Test {
protected:
  TemporaryFolder folder_;
  JobStore store_{folder_.path() / "jobs.sqlite"};
};

TEST_F(JobStoreTest, GivesBackANewJobAndItsCase) {
  const JobRecord record = new_record("r");
  const std::string bytes("\0\1\xff case", 8);
  EXPECT_FALSE(store_.insert(record, bytes, bytes + "complete"));
  EXPECT_TRUE(same(store_.find(record.job.id())->job, record.job));
  EXPECT_TRUE(same(store_.find_request("r")->job, record.job));
  EXPECT_EQ(store_.complete_case(record.job.id()), bytes + "complete");
  EXPECT_FALSE(store_.find(random_uuid()));
  EXPECT_FALSE(store_.complete_case(random_uuid()));
}

TEST_F(JobStoreTest, GivesBackAllThatChangesAlsoAfterOpeningAgain) {
  JobRecord record = new_record();
  store_.insert(record, "", "");
  record.job.set_state(v1::FAILED);
  record.job.set_attempts(3);
  *record.job.mutable_start_time() = timestamp(1700000000200);
  *record.job.mutable_end_time() = timestamp(1700000000300);
  record.job.mutable_failure()->set_message("cause");
  record.job.mutable_last_step()->set_step(17);
  record.job.add_artifacts()->set_name("results.h5");
  record.wish = Wish::cancel;
  record.wish_reason = "why";
  record.losses = 2;
  record.lost_step = 16;
  record.first_loss = "signal 9";
  record.worker = {1234, 567890};
  store_.update(record, Durability::full);
  JobStore again(folder_.path() / "jobs.sqlite");
  const auto found = again.find(record.job.id());
  ASSERT_TRUE(found);
  EXPECT_TRUE(same(found->job, record.job)) << found->job.DebugString();
  EXPECT_EQ(found->wish, Wish::cancel);
  EXPECT_EQ(found->wish_reason, "why");
  EXPECT_EQ(found->losses, 2);
  EXPECT_EQ(found->lost_step, 16);
  EXPECT_EQ(found->first_loss, "signal 9");
  EXPECT_EQ(found->worker.id, 1234);
  EXPECT_EQ(found->worker.start_ticks, 567890u);
}

TEST_F(JobStoreTest, TakesARequestIdOnceAndNoneAnyNumberOfTimes) {
  const JobRecord first = new_record("same");
  EXPECT_FALSE(store_.insert(first, "", ""));
  const auto there = store_.insert(new_record("same"), "", "");
  ASSERT_TRUE(there);
  EXPECT_EQ(there->job.id(), first.job.id());
  EXPECT_FALSE(store_.insert(new_record(), "", ""));
  EXPECT_FALSE(store_.insert(new_record(), "", ""));
  EXPECT_EQ(store_.ids().size(), 3u);
}

TEST_F(JobStoreTest, ListsNewestFirstPageByPage) {
  for (int i = 0; i < 5; ++i) store_.insert(new_record("", 1700000000000 + i / 2), "", "");
  JobStore::Page page{.size = 2};
  std::vector<std::int64_t> created;
  std::set<std::string> ids;
  for (;;) {
    const auto jobs = store_.list(page);
    if (jobs.empty()) break;
    for (const auto& record : jobs) {
      created.push_back(milliseconds(record.job.create_time()));
      ids.insert(record.job.id());
    }
    page.before_ms = created.back();
    page.before_id = jobs.back().job.id();
  }
  EXPECT_EQ(ids.size(), 5u);
  EXPECT_TRUE(std::is_sorted(created.rbegin(), created.rend()));
  EXPECT_EQ(store_.list({.states = {v1::RUNNING, v1::FAILED}}).size(), 0u);
  EXPECT_EQ(store_.list({.states = {v1::RUNNING, v1::QUEUED}}).size(), 5u);
}

TEST_F(JobStoreTest, ForgetsAJobWithItsCase) {
  const JobRecord record = new_record();
  store_.insert(record, "a", "b");
  EXPECT_TRUE(store_.erase(record.job.id()));
  EXPECT_FALSE(store_.erase(record.job.id()));
  EXPECT_FALSE(store_.complete_case(record.job.id()));
}

TEST_F(JobStoreTest, RefusesAStoreOfALaterVersion) {
  {
    Database database(folder_.path() / "later.sqlite");
    database.execute("PRAGMA user_version = 99");
  }
  EXPECT_THROW(JobStore{folder_.path() / "later.sqlite"}, StoreError);
}

}  // namespace
}  // namespace dccast::jobs
