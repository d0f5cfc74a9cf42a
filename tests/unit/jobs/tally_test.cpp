#include "server/jobs/queue/tally.hpp"

#include <gtest/gtest.h>

#include "server/jobs/folder/events.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {
namespace {

TEST(Histogram, AValueCountsInTheClassThatItEnds) {
  constexpr std::array bounds{1.0, 10.0};
  Histogram histogram(bounds);
  for (const double value : {0.5, 1.0, 1.5, 10.0, 11.0}) histogram.add(value);
  EXPECT_EQ(histogram.counts, (std::vector<std::uint64_t>{2, 2}));
  EXPECT_EQ(histogram.count, 5u);
  EXPECT_DOUBLE_EQ(histogram.sum, 24.0);
}

v1::Job ended(v1::JobState state, double run_s, double estimated_s = 0.0) {
  v1::Job job;
  job.set_state(state);
  job.set_owner("anna");
  job.set_attempts(1);
  job.set_run_s(run_s);
  job.set_estimated_s(estimated_s);
  return job;
}

TEST(Tally, AJobCountsOnceWhenItStartsAndOnceWhenItEnds) {
  Tally tally;
  v1::Job job = ended(v1::RUNNING, 0.0);
  *job.mutable_create_time() = timestamp(1000);
  *job.mutable_start_time() = timestamp(6000);
  tally.count(job, v1::QUEUED);
  job.set_attempts(2);
  tally.count(job, v1::QUEUED);  // started again
  job.set_state(v1::FAILED);
  job.set_run_s(30.0);
  job.mutable_failure()->set_kind(v1::Finding::TIME_LIMIT);
  job.mutable_last_step()->set_process_s(20.0);
  job.add_findings()->set_code("no_superheat");
  tally.count(job, v1::RUNNING);
  tally.count(job, v1::FAILED);  // written again
  const TallyFigures figures = tally.figures();

  EXPECT_EQ(figures.wait_s.count, 1u);
  EXPECT_DOUBLE_EQ(figures.wait_s.sum, 5.0);
  EXPECT_DOUBLE_EQ(figures.run_s.sum, 30.0);
  EXPECT_DOUBLE_EQ(figures.processor_s.at("anna"), 20.0);
  EXPECT_EQ(figures.ended.at(v1::FAILED), 1u);
  EXPECT_EQ(figures.failures.at(v1::Finding::TIME_LIMIT), 1u);
  EXPECT_EQ(figures.findings.at({"no_superheat", v1::Finding::SEVERITY_UNSPECIFIED}), 1u);
}

TEST(Forecast, EstimatesAreCorrectedByWhatTheLastJobsTook) {
  Forecast forecast;
  EXPECT_EQ(forecast.run_s(0.0), 0.0);
  EXPECT_EQ(forecast.run_s(10.0), 10.0);
  for (int i = 0; i < 3; ++i) forecast.learn(ended(v1::SUCCEEDED, 30.0, 10.0));
  forecast.learn(ended(v1::CANCELLED, 1.0, 10.0));
  EXPECT_NEAR(forecast.run_s(20.0), 60.0, 1e-9);
  EXPECT_NEAR(forecast.run_s(0.0), 30.0, 1e-9);
}

TEST(Forecast, WhatIsLeftFollowsThePaceOfTheRunOnceItHasOne) {
  const Forecast forecast;
  v1::Job job = ended(v1::RUNNING, 0.0, 100.0);
  EXPECT_DOUBLE_EQ(forecast.remaining_s(job, 10.0), 90.0);
  job.set_estimated_s(0.0);
  job.mutable_last_step()->set_progress(0.25);
  EXPECT_DOUBLE_EQ(forecast.remaining_s(job, 10.0), 30.0);
}

TEST(Forecast, TheHoldSaysNothingAboutThePaceOfWhatFollows) {
  const Forecast forecast;
  v1::Job job = ended(v1::RUNNING, 0.0, 12.0);
  job.mutable_last_step()->set_time_s(-5.0);
  job.mutable_last_step()->set_progress(0.29);
  EXPECT_NEAR(forecast.remaining_s(job, 0.1), 11.9, 1e-9);

  // The pace of a run of 12 s, whose hold took 0.3 s, comes into its own step by step.
  for (const auto& [progress, ran_s, truth_s] :
       {std::tuple{0.35, 1.3, 10.7}, {0.6, 5.4, 6.6}, {0.9, 10.4, 1.6}}) {
    job.mutable_last_step()->set_time_s(1.0);
    job.mutable_last_step()->set_progress(progress);
    EXPECT_GT(forecast.remaining_s(job, ran_s), 0.5 * truth_s) << progress;
    EXPECT_LT(forecast.remaining_s(job, ran_s), 1.5 * truth_s) << progress;
  }
}

TEST(Forecast, AJobStartsWhenThoseBeforeItLeaveAWorker) {
  EXPECT_EQ(Forecast::start_s({}, 2, 1, 10.0), 0.0);
  EXPECT_EQ(Forecast::start_s({}, 2, 3, 10.0), 10.0);
  EXPECT_EQ(Forecast::start_s({5.0, 30.0}, 2, 1, 10.0), 5.0);
  EXPECT_EQ(Forecast::start_s({5.0, 30.0}, 2, 3, 10.0), 25.0);
  EXPECT_EQ(Forecast::start_s({5.0, 30.0}, 2, 4, 10.0), 30.0);
  EXPECT_NEAR(Forecast::start_s({}, 4, 10001, 10.0), 25000.0, 20.0) << "far back it flows evenly";
}

TEST(Log, AnEventIsOneLineInEveryFormat) {
  for (const auto format : {log::Format::text, log::Format::json, log::Format::journal}) {
    testing::internal::CaptureStdout();
    log::set_format(format);
    log::warn("a{}b \"c\" \\", "\nERROR forged\x1b[2J");
    const std::string line = testing::internal::GetCapturedStdout();
    EXPECT_EQ(std::ranges::count(line, '\n'), 1) << line;
    EXPECT_EQ(line.find('\x1b'), std::string::npos);
    if (format == log::Format::journal) {
      EXPECT_EQ(line, "<4>a\\u{A}ERROR forged\\u{1B}[2Jb \"c\" \\\n");
    }
    if (format == log::Format::json) {
      EXPECT_NE(line.find(R"("message":"a\\u{A}ERROR forged\\u{1B}[2Jb \"c\" \\"})"),
                std::string::npos)
          << line;
    }
  }
  log::set_format(log::Format::text);
}

}  // namespace
}  // namespace dccast::jobs
