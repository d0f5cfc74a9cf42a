// Lists of jobs, their order in the queue, their history in pages, and their end.
#include <gmock/gmock.h>

#include "tests/unit/service/service_fixture.hpp"

namespace dccast::service {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;
using enum grpc::StatusCode;

class JobsTest : public ServiceTest {
protected:
  std::vector<std::string> found(const std::function<void(v1::ListJobsRequest&)>& filter) {
    v1::ListJobsRequest request;
    filter(request);
    return listed(user_, request);
  }
  std::vector<std::string> labelled(const std::vector<std::string>& labels) {
    return found([&](auto& list) { list.mutable_labels()->Assign(labels.begin(), labels.end()); });
  }
  v1::Job job(const std::string& id) { return user_.ask(&Stub::GetJob, of<v1::GetJobRequest>(id)); }
  /// Ids of all pages of a list, each of which is checked.
  template <class Check>
  std::vector<std::string> all_pages(v1::ListJobsRequest request, Check&& check) {
    std::vector<std::string> ids;
    do {
      const auto page = user_.ask(&Stub::ListJobs, request);
      check(page);
      for (const v1::Job& of_page : page.jobs()) ids.push_back(of_page.id());
      request.set_page_token(page.next_page_token());
    } while (!request.page_token().empty());
    return ids;
  }
  std::vector<std::string> ended_jobs(int number) {
    std::vector<std::string> ids;
    for (int i = 0; i < number; ++i) ids.push_back(ended_job(user_).id());
    return ids;
  }
  /// Changes all rows, as another program could.
  void change_rows(const v1::Job& values) {
    for (jobs::JobRecord& record : queue_.store.list({.size = jobs::JobStore::Page::all})) {
      record.job.MergeFrom(values);
      queue_.store.put(record);
    }
  }
  std::vector<v1::QueryResultResponse> pages(const std::string& id, int page_size) {
    auto request = of<v1::QueryResultRequest>(id);
    request.set_page_size(page_size);
    std::vector<v1::QueryResultResponse> all;
    do {
      all.push_back(user_.ask(&Stub::QueryResult, request));
      request.set_page_token(all.back().next_page_token());
    } while (!request.page_token().empty());
    return all;
  }
  static std::vector<v1::StepReport> history(int from, int to) {
    std::vector<v1::StepReport> steps;
    for (int i = from; i <= to; ++i) steps.push_back(step(i, 1e-3 * i));
    return steps;
  }
  static std::vector<std::int64_t> numbers(const std::vector<v1::QueryResultResponse>& pages) {
    std::vector<std::int64_t> all;
    for (const auto& page : pages)
      for (const v1::StepReport& step : page.steps()) all.push_back(step.step());
    return all;
  }
  static std::vector<std::int64_t> counted(int from, int to) {
    std::vector<std::int64_t> all;
    for (int i = from; i <= to; ++i) all.push_back(i);
    return all;
  }

  User user_ = local_user();
};

TEST_F(JobsTest, AreFoundByLabelsAndOwner) {
  v1::SubmitJobRequest request = submission();
  request.add_labels("trial-7");
  const std::string one = submitted(user_, request).id();
  queue_.executor.wait_for_launch(1);
  request.add_labels("night shift");
  const v1::Job both = submitted(user_, request);
  const std::string none = submitted(user_).id();

  EXPECT_THAT(both.labels(), ElementsAre("trial-7", "night shift"));
  EXPECT_THAT(labelled({}), UnorderedElementsAre(none, both.id(), one));
  EXPECT_THAT(labelled({"trial-7"}), UnorderedElementsAre(both.id(), one));
  EXPECT_THAT(labelled({"trial-7", "night shift"}), ElementsAre(both.id()));
  EXPECT_THAT(labelled({"trial"}), IsEmpty());
  EXPECT_THAT(labelled({"%"}), IsEmpty());

  EXPECT_EQ(both.owner(), user_name(::geteuid()));
  EXPECT_EQ(found([&](auto& list) { list.set_owner(both.owner()); }).size(), 3u);
  EXPECT_THAT(found([](auto& list) { list.set_owner("nobody at all"); }), IsEmpty());
}

TEST_F(JobsTest, AreFoundByStateAndTheBeginningOfTheirId) {
  const auto ids = ended_jobs(30);
  for (const std::string& id : ids) {
    EXPECT_THAT(found([&](auto& list) { list.set_id_prefix(id.substr(0, 2)); }),
                ::testing::Contains(id));
    EXPECT_THAT(found([&](auto& list) { list.set_id_prefix(id); }), ElementsAre(id));
  }
  EXPECT_THAT(found([](auto& list) { list.set_id_prefix("~"); }), IsEmpty());
  EXPECT_THAT(found([](auto& list) { list.add_states(v1::FAILED); }), IsEmpty());
  EXPECT_EQ(found([](auto& list) { list.add_states(v1::SUCCEEDED); }).size(), 30u);

  v1::ListJobsRequest paged;
  paged.set_page_size(7);
  const auto listed = all_pages(paged, [](const auto& page) { EXPECT_LE(page.jobs_size(), 7); });
  EXPECT_THAT(listed, ::testing::UnorderedElementsAreArray(ids));
  paged.set_page_token("yesterday");
  user_.refusal(INVALID_ARGUMENT, &Stub::ListJobs, paged);
}

TEST_F(JobsTest, OfAStudyAreThoseThatNameIt) {
  v1::SubmitJobRequest request = submission();
  request.set_study("0f2b9a4e-0000-4000-8000-000000000000");
  const std::string first = ended_job(user_, request).id(), second = ended_job(user_, request).id();
  v1::SubmitJobRequest other = submission();
  other.set_study("0f2b9a4e-0000-4000-8000-000000000001");
  const std::string apart = ended_job(user_, other).id(), alone = ended_job(user_).id();

  const auto of_study = [&] { return found([&](auto& l) { l.set_study(request.study()); }); };
  EXPECT_EQ(job(first).study(), request.study());
  EXPECT_EQ(job(alone).study(), "");
  EXPECT_THAT(of_study(), UnorderedElementsAre(first, second));
  EXPECT_THAT(listed(user_), UnorderedElementsAre(first, second, apart, alone));
  user_.ask(&Stub::DeleteJob, of<v1::DeleteJobRequest>(first));
  EXPECT_THAT(of_study(), ElementsAre(second));
}

TEST_F(JobsTest, AreListedInPagesOfBoundedSizeWhateverTheyHold) {
  const auto check = [](const auto& page) { EXPECT_LT(page.ByteSizeLong(), 1.1 * (1 << 20)); };
  const auto ids = ended_jobs(30);
  v1::Job large;
  large.set_state(v1::FAILED);
  large.mutable_failure()->set_message(std::string(1'000'000, 'x'));
  large.mutable_failure()->mutable_residual_history()->Resize(100'000, 1.0);
  change_rows(large);
  EXPECT_THAT(all_pages({}, check), ::testing::UnorderedElementsAreArray(ids));

  std::string title;
  for (int i = 0; i < 2'500'000; ++i) title += "é";
  v1::Job titled;
  titled.set_title(title);
  change_rows(titled);
  EXPECT_THAT(all_pages({}, check), ::testing::UnorderedElementsAreArray(ids));
}

/// What is kept of a job is there after the server was started again.
TEST_F(JobsTest, KeepWhatWasSubmittedWithThem) {
  v1::SubmitJobRequest request = submission();
  request.add_labels("trial-7");
  v1::CaseChange& change = *request.add_changes();
  change.set_key("schedule.water_flow.scale");
  change.set_value("0.8 until 100 mm");
  const v1::Job made = ended_job(user_, request);
  jobs::Daemon again(options_.jobs_directory);
  const v1::Job kept = again.store.list({}).front().job;
  for (const v1::Job& one : {made, job(made.id()), kept}) {
    EXPECT_EQ(one.changes(0).SerializeAsString(), change.SerializeAsString());
    EXPECT_THAT(one.labels(), ElementsAre("trial-7"));
    EXPECT_EQ(one.owner(), made.owner());
  }
}

TEST_F(JobsTest, WaitInTheOrderOfTheirPriority) {
  submitted(user_);
  queue_.executor.wait_for_launch(1);
  v1::SubmitJobRequest request = submission();
  request.set_priority(v1::LOW);
  const std::string low = submitted(user_, request).id();
  const std::string normal = submitted(user_).id();
  EXPECT_EQ(job(normal).queue_position(), 1);
  EXPECT_EQ(job(low).queue_position(), 2);

  const auto cancel = of<v1::CancelJobRequest>(normal);
  EXPECT_EQ(user_.ask(&Stub::CancelJob, cancel).state(), v1::CANCELLED);
  EXPECT_EQ(user_.ask(&Stub::CancelJob, cancel).state(), v1::CANCELLED);
  EXPECT_EQ(job(low).queue_position(), 1);
  const auto events = user_.ask(&Stub::WatchJob, of<v1::WatchJobRequest>(normal));
  ASSERT_EQ(events.size(), 2u) << "queued, cancelled";
  EXPECT_TRUE(events[1].state_change().terminal());
}

TEST_F(JobsTest, AreDeletedOnceTheyHaveEnded) {
  const std::string id = submitted(user_).id();
  const auto request = of<v1::DeleteJobRequest>(id);
  queue_.executor.wait_for_launch(1);
  user_.refusal(FAILED_PRECONDITION, &Stub::DeleteJob, request);
  user_.refusal(FAILED_PRECONDITION, &Stub::FetchResult, of<v1::FetchResultRequest>(id));
  auto frame = of<v1::QueryResultRequest>(id);
  frame.set_frame(true);
  user_.refusal(FAILED_PRECONDITION, &Stub::QueryResult, frame);

  run_next_job({});
  user_.refusal(FAILED_PRECONDITION, &Stub::PauseJob, of<v1::PauseJobRequest>(id));
  user_.refusal(FAILED_PRECONDITION, &Stub::ResumeJob, of<v1::ResumeJobRequest>(id));
  user_.ask(&Stub::DeleteJob, request);
  user_.refusal(NOT_FOUND, &Stub::GetJob, of<v1::GetJobRequest>(id));
  EXPECT_FALSE(std::filesystem::exists(options_.jobs_directory / id));
}

TEST_F(JobsTest, HaveAHistoryInPages) {
  const std::string id = ended_job(user_, submission(), history(1, 60)).id();
  const auto all = pages(id, 7);
  EXPECT_EQ(numbers(all), counted(1, 60));
  ASSERT_EQ(all.size(), 9u);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].steps_size(), i < 8 ? 7 : 4);
    EXPECT_EQ(all[i].has_case_(), i == 0);
  }

  auto request = of<v1::QueryResultRequest>(id);
  for (const char* token : {"yesterday", "1", "1.", "-1.2", "1.2.3"}) {
    request.set_page_token(token);
    EXPECT_THAT(user_.refusal(INVALID_ARGUMENT, &Stub::QueryResult, request).error_message(),
                HasSubstr("page_token"));
  }
  request.clear_page_token();
  request.set_page_size(-1);
  user_.refusal(INVALID_ARGUMENT, &Stub::QueryResult, request);
}

TEST_F(JobsTest, HaveSamplesOfTheirHistory) {
  auto request = of<v1::QueryResultRequest>(ended_job(user_, submission(), history(1, 60)).id());
  const auto sampled = [&](int samples) {
    request.set_samples(samples);
    return numbers({user_.ask(&Stub::QueryResult, request)});
  };
  EXPECT_EQ(sampled(60), counted(1, 60));
  EXPECT_EQ(sampled(1000), counted(1, 60));
  EXPECT_EQ(sampled(7), (std::vector<std::int64_t>{1, 17, 33, 49, 60}));
  EXPECT_EQ(sampled(2), (std::vector<std::int64_t>{1, 60}));

  EXPECT_FALSE(user_.ask(&Stub::QueryResult, request).has_case_());
  for (const int samples : {-1, 1, 1001}) {
    request.set_samples(samples);
    EXPECT_THAT(user_.refusal(INVALID_ARGUMENT, &Stub::QueryResult, request).error_message(),
                HasSubstr("permitted: 0, or 2 to 1000"));
  }
}

TEST_F(JobsTest, HaveAHistoryInPagesOfBoundedSize) {
  const std::string id = ended_job(user_, submission(), history(1, 25'000)).id();
  const auto all = pages(id, 0);
  EXPECT_GT(all.size(), 1u);
  for (const auto& page : all) EXPECT_LT(page.ByteSizeLong(), 1.1 * (1 << 20));
  EXPECT_EQ(numbers(all), counted(1, 25'000));
}

TEST_F(JobsTest, HaveAHistoryWhosePagesMayEndBehindACheckpointThatTheRunWentBackTo) {
  const std::string id = submitted(user_).id();
  jobs::FakeWorker worker(queue_.executor.wait_for_launch(1));
  for (int i = 1; i <= 12; ++i) worker.step(i);
  // A run reports from a thread of its own.
  ASSERT_TRUE(eventually([&] { return numbers(pages(id, 0)) == counted(1, 12); }));

  const auto first_page = [&](int size) {
    auto request = of<v1::QueryResultRequest>(id);
    request.set_page_size(size);
    request.set_page_token(user_.ask(&Stub::QueryResult, request).next_page_token());
    request.clear_page_size();
    return request;
  };
  const auto stays = first_page(5), goes = first_page(11);
  worker.resume(10);
  for (int i = 11; i <= 30; ++i) worker.step(i);
  worker.end(v1::RunEnd::SUCCEEDED);
  queue_.executor.end(worker.launch(), "exit code 0", 0);
  ASSERT_TRUE(becomes(queue_, id, v1::SUCCEEDED));

  EXPECT_EQ(numbers({user_.ask(&Stub::QueryResult, stays)}), counted(6, 30));
  EXPECT_THAT(user_.refusal(ABORTED, &Stub::QueryResult, goes).error_message(),
              HasSubstr("begin again"));
}

}  // namespace
}  // namespace dccast::service
