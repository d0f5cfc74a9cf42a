#include "server/studies/study_store.hpp"

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "proto/values/digests.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/store/job_store.hpp"
#include "server/studies/study_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::studies {
namespace {

using google::protobuf::util::MessageDifferencer;

class StudyStoreTest : public testing::Test {
protected:
  StudyRecord study(const std::string& request_id = "r", std::int64_t created_ms = 1000) {
    StudyRecord record;
    record.id = values::random_uuid();
    record.owner = "someone";
    record.created_ms = record.changed_ms = created_ms;
    record.case_sha256 = "abc";
    record.request.set_request_id(request_id);
    record.request.mutable_case_()->set_title("a case");
    record.request.mutable_refinement()->set_levels(3);
    return record;
  }

  std::vector<RunRecord> three_runs() {
    std::vector<RunRecord> runs(3);
    for (int i = 0; i < 3; ++i) runs[static_cast<std::size_t>(i)].number = i;
    return runs;
  }

  std::string job(v1::JobState state, const std::string& study, std::int64_t ended_ms = 0) {
    jobs::JobRecord record;
    record.job.set_id(values::random_uuid());
    record.job.set_study(study);
    record.job.set_state(state);
    *record.job.mutable_create_time() = jobs::timestamp(1000);
    jobs_.insert(record);
    if (ended_ms > 0) *record.job.mutable_end_time() = jobs::timestamp(ended_ms);
    jobs_.put(record);
    return record.job.id();
  }

  void give_job(const std::string& id, int number, const std::string& job_id) {
    RunRecord run;
    run.number = number;
    run.attempt = 1;
    run.job = job_id;
    EXPECT_TRUE(store_.set_job(id, run));
  }

  TemporaryFolder folder_;
  jobs::JobStore jobs_{folder_.path() / "jobs.sqlite"};
  StudyStore store_{folder_.path() / "jobs.sqlite"};
};

TEST_F(StudyStoreTest, KeepsWhatAStudyIs) {
  const StudyRecord record = study();
  EXPECT_TRUE(store_.insert(record, three_runs()));
  EXPECT_FALSE(store_.insert(study(), three_runs()));  // the same request_id

  StudyStore again(folder_.path() / "jobs.sqlite");
  const auto found = again.find(record.id);
  ASSERT_TRUE(found);
  EXPECT_TRUE(MessageDifferencer::Equals(found->request, record.request));
  EXPECT_EQ(found->owner, "someone");
  EXPECT_EQ(found->case_sha256, "abc");
  EXPECT_EQ(again.find_request("r")->id, record.id);
  EXPECT_FALSE(again.find_request("another"));
  EXPECT_EQ(again.runs(record.id).size(), 3u);
  EXPECT_EQ(again.counts(record.id).of(v1::QUEUED), 3);
}

TEST_F(StudyStoreTest, CountsRunsByTheStateOfTheirJobs) {
  const StudyRecord record = study();
  store_.insert(record, three_runs());
  give_job(record.id, 0, job(v1::SUCCEEDED, record.id, 5000));
  const std::string deleted = job(v1::SUCCEEDED, record.id, 4000);
  give_job(record.id, 1, deleted);
  RunCounts counts = store_.counts(record.id);
  EXPECT_EQ(counts.of(v1::SUCCEEDED), 2);
  EXPECT_EQ(counts.of(v1::QUEUED), 1);
  EXPECT_EQ(counts.waiting, 0);  // it has no job yet
  EXPECT_EQ(counts.last_end_ms, 5000);
  jobs_.erase(deleted);
  EXPECT_EQ(store_.counts(record.id).all(), 2);
}

TEST_F(StudyStoreTest, SaysWhatIsToBeQueued) {
  const StudyRecord first = study("a", 1000), second = study("b", 2000);
  store_.insert(second, three_runs());
  store_.insert(first, three_runs());
  EXPECT_EQ(store_.to_feed(), (std::vector{first.id, second.id}));
  EXPECT_EQ(store_.next_to_queue(first.id)->number, 0);

  give_job(first.id, 0, job(v1::QUEUED, first.id));
  EXPECT_EQ(store_.next_to_queue(first.id)->number, 1);

  store_.refuse(first.id, 1, {}, 3000);
  store_.cancel_waiting(first.id, 3500);
  EXPECT_EQ(store_.to_feed(), std::vector{second.id});

  const RunCounts counts = store_.counts(first.id);
  EXPECT_EQ(counts.of(v1::FAILED), 1);
  EXPECT_EQ(counts.of(v1::CANCELLED), 1);
  EXPECT_EQ(counts.waiting, 1);
  EXPECT_EQ(store_.find(first.id)->changed_ms, 3500);

  RunRecord late;
  late.number = 2;
  late.job = "x";
  EXPECT_FALSE(store_.set_job(first.id, late));  // cancelled meanwhile

  store_.queue_again(first.id, {{.number = 2, .failure = {}}});
  EXPECT_EQ(store_.next_to_queue(first.id)->number, 2);
}

TEST_F(StudyStoreTest, AStudyThatIsBeingRemovedIsNoLongerThere) {
  const StudyRecord record = study();
  store_.insert(record, three_runs());
  store_.begin_removal(record.id);
  EXPECT_FALSE(store_.find(record.id));
  EXPECT_TRUE(store_.ids().empty());
  EXPECT_TRUE(store_.to_feed().empty());
  ASSERT_EQ(store_.removing().size(), 1U);
  EXPECT_EQ(store_.removing().front().id, record.id);
  EXPECT_EQ(store_.removing().front().owner, record.owner);
  store_.erase(record.id);
  EXPECT_TRUE(store_.removing().empty());
  EXPECT_TRUE(store_.runs(record.id).empty());
}

TEST_F(StudyStoreTest, ListsNewestFirstPageByPage) {
  std::vector<std::string> ids;
  for (int i = 0; i < 5; ++i) {
    const StudyRecord record = study("r" + std::to_string(i), 1000 + i);
    store_.insert(record, {});
    ids.insert(ids.begin(), record.id);
  }
  const auto first = store_.list({.size = 2});
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[1].id, ids[1]);

  const auto second =
      store_.list({.before_ms = first[1].created_ms, .before_id = first[1].id, .size = 10});
  ASSERT_EQ(second.size(), 3u);
  EXPECT_EQ(second[2].id, ids[4]);
}

TEST_F(StudyStoreTest, ListsByOwnerBeginningOfIdAndLabels) {
  StudyRecord both = study("a", 1001), one = study("b", 1000);
  both.owner = "jo";
  both.request.add_labels("trial");
  both.request.add_labels("a b");
  one.request.add_labels("trial");
  store_.insert(both, {});
  store_.insert(one, {});

  EXPECT_EQ(store_.list({.owner = "jo"}).size(), 1u);
  EXPECT_EQ(store_.list({.labels = {"trial"}}).size(), 2u);
  EXPECT_EQ(store_.list({.size = 1, .labels = {"trial"}}).front().id, both.id);
  EXPECT_EQ(store_.list({.labels = {"trial", "a b"}}).size(), 1u);
  EXPECT_TRUE(store_.list({.labels = {"tri"}}).empty());
  EXPECT_TRUE(store_.list({.owner = "jo", .id_prefix = one.id}).empty());
  EXPECT_EQ(store_.list({.id_prefix = one.id.substr(0, 13)}).front().id, one.id);
}

TEST_F(StudyStoreTest, FindsALabelBehindManyStudiesWithoutIt) {
  StudyRecord oldest = study("oldest", 1);
  oldest.request.add_labels("trial");
  store_.insert(oldest, {});
  for (int i = 0; i < 250; ++i) store_.insert(study("r" + std::to_string(i), 1000), {});

  const auto found = store_.list({.size = 2, .labels = {"trial"}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found.front().id, oldest.id);
}

TEST_F(StudyStoreTest, AFileSaysWhatTheRowSays) {
  const StudyRecord record = study();
  write_study_file(folder_.path(), record);
  EXPECT_EQ(ids_of_study_files(folder_.path()), std::set{record.id});

  const StudyRecord read = read_study_file(folder_.path(), record.id);
  EXPECT_TRUE(MessageDifferencer::Equals(read.request, record.request));
  EXPECT_EQ(read.case_sha256, record.case_sha256);
  EXPECT_EQ(read.created_ms, record.created_ms);

  {
    std::fstream file(study_file(folder_.path(), record.id), std::ios::in | std::ios::out);
    file.seekp(40);
    file.put('\xff');
  }
  EXPECT_THROW(read_study_file(folder_.path(), record.id), std::runtime_error);

  remove_study_file(folder_.path(), record.id);
  EXPECT_THROW(read_study_file(folder_.path(), record.id), std::runtime_error);
}

/// Of another connection: a wait for it once took ten seconds, and held up those who read.
TEST_F(StudyStoreTest, ALockOfAnotherProcessStopsChangesForASecondAndNoReader) {
  const StudyRecord record = study();
  store_.insert(record, three_runs());
  jobs::Database other(folder_.path() / "jobs.sqlite");
  other.execute("BEGIN IMMEDIATE");

  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  std::thread changing([&] { EXPECT_THROW(store_.begin_removal(record.id), jobs::StoreError); });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // it waits for the lock by then
  EXPECT_TRUE(store_.find(record.id));
  EXPECT_LT(elapsed_s(), 0.9);
  changing.join();
  EXPECT_LT(elapsed_s(), 1.8);

  other.execute("ROLLBACK");
  store_.begin_removal(record.id);
  EXPECT_FALSE(store_.find(record.id));
}

}  // namespace
}  // namespace dccast::studies
