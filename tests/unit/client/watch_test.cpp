#include <grpcpp/server_builder.h>

#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/session/jobs.hpp"
#include "client/session/studies.hpp"
#include "fake_service.hpp"

namespace dccast::client {
namespace {

const RetryPolicy quick{5, std::chrono::milliseconds(1), std::chrono::milliseconds(4)};

struct Watch : testing::Test {
  FakeService service;
  std::vector<std::int64_t> seen;
  std::ostringstream messages;

  v1::JobEvent::StateChange follow(std::int64_t from = 1) {
    Connection connection = service.connect();
    return follow_job(
        connection, "job", from, [&](const v1::JobEvent& e) { seen.push_back(e.sequence()); },
        messages, quick);
  }
  void SetUp() override {
    service.job.set_id("job");
    service.events = run_of(7);
  }
};

TEST_F(Watch, EverythingInOneStream) {
  EXPECT_EQ(follow().state(), v1::SUCCEEDED);
  EXPECT_THAT(seen, testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
  EXPECT_EQ(messages.str(), "");
}

TEST_F(Watch, ACutStreamIsTakenUpAgainWithoutLossOrRepetition) {
  service.events_per_stream = 3;
  service.repeated_events = 2;
  EXPECT_EQ(follow().state(), v1::SUCCEEDED);
  EXPECT_THAT(seen, testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
  EXPECT_EQ(service.streams, 4);
  EXPECT_THAT(messages.str(), testing::HasSubstr("the job has not"));
}

TEST_F(Watch, BeginsWhereItIsTold) {
  follow(8);
  EXPECT_THAT(seen, testing::ElementsAre(8, 9, 10));
}

TEST_F(Watch, AHoleIsAskedForAgainAndNeverPassedOver) {
  service.events.erase(service.events.begin() + 4);
  EXPECT_THROW(follow(), CommandFailed);
  EXPECT_THAT(seen, testing::ElementsAre(1, 2, 3, 4));
}

TEST_F(Watch, AnEndWithoutTerminalEventIsNeverTheEndOfTheJob) {
  service.events.pop_back();
  try {
    follow();
    FAIL() << "took the end of the stream for the end of the job";
  } catch (const CommandFailed& failure) {
    EXPECT_EQ(failure.code(), ExitCode::unreachable);
    EXPECT_THAT(failure.what(), testing::HasSubstr("dccast watch --from 10 job"));
  }
}

TEST_F(Watch, AnUnknownJobIsNotAskedForTwice) {
  service.job.set_id("other");
  EXPECT_THROW(follow(), CommandFailed);
  EXPECT_EQ(service.streams, 1);
}

/// Ends every stream about a study before its first word.
struct SilentStudies final : v1::SimulationService::Service {
  std::atomic<int> streams{0};
  grpc::Status WatchStudy(grpc::ServerContext*, const v1::WatchStudyRequest*,
                          grpc::ServerWriter<v1::Study>*) override {
    ++streams;
    return grpc::Status::OK;
  }
};

TEST(WatchOfAStudy, IsTakenUpAgainAsOftenAsItSays) {
  SilentStudies service;
  int port = 0;
  const auto server = grpc::ServerBuilder()
                          .AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port)
                          .RegisterService(&service)
                          .BuildAndStart();
  Connection connection(Endpoint{.address = "127.0.0.1:" + std::to_string(port)});
  std::ostringstream messages;

  EXPECT_THROW(follow_study(
                   connection, "study", [](const v1::Study&) {}, messages, quick),
               CommandFailed);
  EXPECT_THAT(messages.str(), testing::HasSubstr("taking it up again (attempt 4 of 4)"));
  EXPECT_EQ(service.streams, 5);
}

}  // namespace
}  // namespace dccast::client
