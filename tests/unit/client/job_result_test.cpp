#include "client/session/jobs.hpp"

#include <gtest/gtest.h>

#include "fake_service.hpp"

namespace dccast::client {
namespace {

struct JobResult : testing::Test {
  FakeService service;
  Connection connection = service.connect();
  void SetUp() override {
    for (const v1::JobEvent& event : run_of(7))
      if (event.has_step()) *service.result.add_steps() = event.step();
    service.result.mutable_case_()->set_title("paged");
    service.steps_per_page = 3;
  }
};

TEST_F(JobResult, EveryPageIsReadAndPutTogether) {
  const v1::QueryResultResponse result = query_result(connection, "job");
  ASSERT_EQ(result.steps_size(), 7);
  for (int i = 0; i < 7; ++i) EXPECT_EQ(result.steps(i).step(), i + 1);
  EXPECT_EQ(result.case_().title(), "paged");
  EXPECT_EQ(result.next_page_token(), "");
}

TEST_F(JobResult, AHistoryThatWasTakenBackIsReadAnew) {
  service.aborted_pages = 2;
  EXPECT_EQ(query_result(connection, "job").steps_size(), 7);
  service.aborted_pages = 100;
  EXPECT_THROW(query_result(connection, "job"), CommandFailed);
}

}  // namespace
}  // namespace dccast::client
