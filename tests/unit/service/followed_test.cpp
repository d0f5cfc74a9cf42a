// What a job that follows a casting is refused for, and its readings.
#include <gmock/gmock.h>

#include "tests/unit/service/service_fixture.hpp"

namespace dccast::service {
namespace {

using ::testing::HasSubstr;
using enum grpc::StatusCode;

class FollowedTest : public ServiceTest {
protected:
  using ServiceTest::ServiceTest;

  /// A casting with a gauge at each of these monitors.
  static v1::SubmitJobRequest measured_at(const std::vector<std::string>& monitors) {
    v1::SubmitJobRequest request = submission();
    request.mutable_following();
    for (const std::string& monitor : monitors) {
      v1::Gauge& gauge = *request.mutable_following()->add_gauges();
      gauge.set_monitor(monitor);
      gauge.set_noise_m(1e-3);
    }
    return request;
  }
  static v1::AppendReadingsRequest reading_of(const std::string& job, std::int64_t number) {
    auto request = of<v1::AppendReadingsRequest>(job);
    v1::Reading& reading = *request.add_readings();
    reading.set_number(number);
    reading.set_time_s(static_cast<double>(number));
    reading.set_casting_speed_m_per_s(1e-3);
    return request;
  }

  User user_ = local_user();
};

/// A record is read with a bound: one with 4,000 gauges was written, and held the queue of all.
TEST_F(FollowedTest, GaugesBeyondWhatARecordTakesMakeNoJob) {
  const auto refusal =
      user_.refusal(INVALID_ARGUMENT, &Stub::SubmitJob,
                    measured_at(std::vector<std::string>(4000, "corner of the narrow face")));
  EXPECT_THAT(refusal.error_message(), HasSubstr("give fewer gauges"));
  EXPECT_TRUE(listed(user_).empty());
}

/// Each curl is looked up among all gauges.
TEST_F(FollowedTest, AMonitorHasOneGaugeAndAGaugeOneCurlInAReading) {
  const auto twice = user_.refusal(INVALID_ARGUMENT, &Stub::SubmitJob, measured_at({"lip", "lip"}));
  EXPECT_THAT(twice.error_message(), HasSubstr("has two gauges"));

  const std::string job = submitted(user_, measured_at({"lip"})).id();
  auto request = reading_of(job, 1);
  for (int i = 0; i < 2; ++i) request.mutable_readings(0)->add_curls()->set_monitor("lip");
  const auto refusal = user_.refusal(INVALID_ARGUMENT, &Stub::AppendReadings, request);
  EXPECT_THAT(refusal.error_message(), HasSubstr("has two curls"));
  EXPECT_EQ(user_.ask(&Stub::AppendReadings, of<v1::AppendReadingsRequest>(job)).number(), 0);
}

class OnAFullDisk : public FollowedTest {
protected:
  OnAFullDisk()
      : FollowedTest([](v1::DaemonConfig& settings) {
          settings.mutable_limits()->set_minimum_free_bytes(1e15);
        }) {}
};

TEST_F(OnAFullDisk, NoReadingIsTaken) {
  const std::string job = submitted(user_, measured_at({})).id();
  const auto refusal = user_.refusal(RESOURCE_EXHAUSTED, &Stub::AppendReadings, reading_of(job, 1));
  EXPECT_THAT(refusal.error_message(), HasSubstr("free"));
  EXPECT_EQ(user_.ask(&Stub::AppendReadings, of<v1::AppendReadingsRequest>(job)).number(), 0);
}

}  // namespace
}  // namespace dccast::service
