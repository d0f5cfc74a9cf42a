#include "server/jobs/store/job_store.hpp"

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/folder/events.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

JobRecord new_record(const std::string& request_id = "", std::int64_t created_ms = 1700000000123) {
  JobRecord record;
  record.job.set_id(values::random_uuid());
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

TEST_F(JobStoreTest, GivesBackANewJob) {
  JobRecord record = new_record("r");
  record.job.set_study(values::random_uuid());
  EXPECT_FALSE(store_.insert(record));
  EXPECT_TRUE(same(store_.find(record.job.id())->job, record.job));
  EXPECT_TRUE(same(store_.find_request("r")->job, record.job));
  EXPECT_FALSE(store_.find(values::random_uuid()));
}

TEST_F(JobStoreTest, ADamagedRowIsNeverRead) {
  const std::filesystem::path path = folder_.path() / "damaged.sqlite";
  {
    JobRecord record = new_record();
    JobStore store(path);
    store.insert(record);
    record.job.set_state(v1::SUCCEEDED);
    record.job.add_artifacts()->set_sha256("5ca1ab1e");
    store.put(record);
    EXPECT_EQ(store.first_fault(), "");
  }
  std::string bytes = storage::read_file(path);
  const auto at = bytes.find("5ca1ab1e");
  ASSERT_NE(at, std::string::npos);

  bytes[at] ^= 1;
  std::ofstream(path, std::ios::binary) << bytes;
  JobStore damaged(path);
  try {
    damaged.list({});
    FAIL();
  } catch (const StoreError& error) {
    EXPECT_TRUE(must_be_rebuilt(error)) << error.what();
  }
}

TEST_F(JobStoreTest, GivesBackAllThatChangesAlsoAfterOpeningAgain) {
  JobRecord record = new_record();
  store_.insert(record);
  record.job.set_state(v1::FAILED);
  record.job.set_attempts(3);
  record.job.mutable_validity_loss()->set_message("slides");
  *record.job.mutable_start_time() = timestamp(1700000000200);
  *record.job.mutable_end_time() = timestamp(1700000000300);
  record.job.mutable_failure()->set_message("cause");
  record.job.mutable_last_step()->set_step(17);
  record.job.add_artifacts()->set_name("results.h5");
  record.losses.set_times(2);
  record.losses.set_last_step(16);
  record.losses.set_first_cause("signal 9");
  record.sequence = 12;
  store_.put(record);
  JobStore again(folder_.path() / "jobs.sqlite");
  const auto found = again.find(record.job.id());

  ASSERT_TRUE(found);
  EXPECT_TRUE(same(found->job, record.job)) << found->job.DebugString();
  EXPECT_EQ(found->losses.SerializeAsString(), record.losses.SerializeAsString());
  EXPECT_EQ(found->sequence, 12);
}

TEST_F(JobStoreTest, TakesARequestIdOnceAndNoneAnyNumberOfTimes) {
  const JobRecord first = new_record("same");
  EXPECT_FALSE(store_.insert(first));
  const auto there = store_.insert(new_record("same"));
  ASSERT_TRUE(there);
  EXPECT_EQ(there->job.id(), first.job.id());
  EXPECT_FALSE(store_.insert(new_record()));
  EXPECT_FALSE(store_.insert(new_record()));
  EXPECT_EQ(store_.ids().size(), 3u);
}

TEST_F(JobStoreTest, ListsNewestFirstPageByPage) {
  for (int i = 0; i < 5; ++i) store_.insert(new_record("", 1700000000000 + i / 2));
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

TEST_F(JobStoreTest, ListsTheJobsOfAStudyOnly) {
  const std::string study = values::random_uuid();
  std::set<std::string> members;
  for (int i = 0; i < 6; ++i) {
    JobRecord record = new_record("", 1700000000000 + i);
    if (i % 2 == 0) record.job.set_study(i == 4 ? values::random_uuid() : study);
    if (record.job.study() == study) members.insert(record.job.id());
    store_.insert(record);
  }
  std::set<std::string> listed;

  for (const JobRecord& record : store_.list({.study = study})) {
    EXPECT_EQ(record.job.study(), study);
    listed.insert(record.job.id());
  }
  EXPECT_EQ(listed, members);
  EXPECT_EQ(store_.list({}).size(), 6u);
  EXPECT_EQ(store_.list({.study = study, .size = 1}).size(), 1u);
  EXPECT_TRUE(store_.list({.states = {v1::FAILED}, .study = study}).empty());
  EXPECT_TRUE(store_.list({.study = values::random_uuid()}).empty());
}

TEST_F(JobStoreTest, AStudyOutlivesAMemberThatIsDeleted) {
  JobRecord first = new_record(), second = new_record();
  for (JobRecord* record : {&first, &second}) {
    record->job.set_study("s");
    store_.insert(*record);
  }
  store_.erase(first.job.id());
  const auto left = store_.list({.study = "s"});
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left.front().job.id(), second.job.id());
}

TEST_F(JobStoreTest, KnowsWhatUnfinishedJobsTake) {
  JobRecord waiting = new_record(), ended = new_record();
  waiting.bytes = 70;
  ended.bytes = 500;
  waiting.job.set_owner("someone");
  store_.insert(waiting);
  store_.insert(ended);
  EXPECT_EQ(store_.unfinished_bytes(), 570);
  ended.job.set_state(v1::SUCCEEDED);
  store_.put(ended);
  EXPECT_EQ(store_.unfinished_bytes(), 70);
  EXPECT_EQ(store_.find(waiting.job.id())->job.owner(), "someone");
  EXPECT_EQ(store_.find(waiting.job.id())->bytes, 70);
}

TEST_F(JobStoreTest, FindsJobsByLabelsOwnerAndTheBeginningOfTheirIds) {
  JobRecord both = new_record(), one = new_record(), none = new_record();
  both.job.add_labels("a b");
  both.job.add_labels("trial");
  both.job.set_owner("jo");
  one.job.add_labels("trial");
  v1::CaseChange& change = *one.job.add_changes();
  change.set_key("mesh.rows");
  change.set_value("30");
  for (const JobRecord* record : {&both, &one, &none}) store_.insert(*record);

  EXPECT_TRUE(same(store_.find(both.job.id())->job, both.job));
  EXPECT_TRUE(same(store_.find(one.job.id())->job, one.job));
  EXPECT_EQ(store_.list({.labels = {"trial"}}).size(), 2u);
  EXPECT_EQ(store_.list({.labels = {"trial", "a b"}}).size(), 1u);
  EXPECT_TRUE(store_.list({.labels = {"tri"}}).empty());
  EXPECT_EQ(store_.list({.owner = "jo"}).front().job.id(), both.job.id());

  const auto found = store_.list({.id_prefix = one.job.id().substr(0, 13)});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found.front().job.id(), one.job.id());
  EXPECT_TRUE(store_.list({.id_prefix = "x"}).empty());
}

TEST_F(JobStoreTest, FindsTheNewestAnswerOfTheSameSolver) {
  JobRecord older = new_record(), newer = new_record("", 1700000000999);
  for (JobRecord* record : {&older, &newer}) {
    record->answer_key = "key";
    store_.insert(*record);
    record->job.set_state(v1::SUCCEEDED);
    record->solver = "solver";
    EXPECT_FALSE(record == &older && store_.find_answer("key", "solver")) << "it has not ended";
    store_.put(*record);
  }
  EXPECT_EQ(store_.find_answer("key", "solver"), newer.job.id());
  EXPECT_EQ(store_.find(newer.job.id())->solver, "solver");
  EXPECT_FALSE(store_.find_answer("key", "another solver"));
  EXPECT_FALSE(store_.find_answer("another key", "solver"));
  EXPECT_FALSE(store_.find_answer("", "")) << "nobody knows what computed such a job";
}

TEST_F(JobStoreTest, ForgetsAJob) {
  const JobRecord record = new_record();
  store_.insert(record);
  store_.erase(record.job.id());
  EXPECT_FALSE(store_.find(record.job.id()));
  store_.erase(record.job.id());
}

TEST_F(JobStoreTest, AStoreOfAnotherVersionMustBeRebuilt) {
  for (const int version : {6, 99}) {
    const auto path = folder_.path() / std::to_string(version);
    Database(path).execute(("PRAGMA user_version = " + std::to_string(version)).c_str());
    try {
      const JobStore store(path);
      FAIL() << version;
    } catch (const StoreError& error) {
      EXPECT_TRUE(must_be_rebuilt(error)) << error.what();
    }
  }
}

TEST_F(JobStoreTest, ALockOfAnotherProcessIsAwaitedForASecond) {
  Database other(folder_.path() / "jobs.sqlite");
  other.execute("BEGIN IMMEDIATE");
  const auto begin = std::chrono::steady_clock::now();
  try {
    store_.put(new_record());
    FAIL() << "was written without the lock";
  } catch (const StoreError& error) {
    EXPECT_TRUE(is_passing(error)) << error.what();
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(1800));

  std::thread writing([&] { store_.put(new_record("r")); });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // it waits for the lock by then
  other.execute("ROLLBACK");
  writing.join();
  EXPECT_TRUE(store_.find_request("r"));
}

}  // namespace
}  // namespace dccast::jobs
