#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting::testing {

/// The complete output of a run. Two runs are equal if all of it is, except the processor times in
/// the step reports; results.h5 and results.xdmf contain no clock readings.
struct Given {
  std::vector<results::StepReport> reports;
  RunOutcome outcome;
  std::string results, sidecar;
};

/// Runs a case, stopping after each of the steps and going on again.
inline Given run_with_stops(const Case& c, const std::vector<std::int64_t>& stops) {
  const TemporaryFolder folder;
  Given given;
  for (std::size_t life = 0; life <= stops.size(); ++life) {
    Recorder recorder;
    if (life < stops.size()) recorder.act_after = stops[life];
    recorder.then = Order::stop_at_checkpoint;
    recorder.before = given.reports;
    given.outcome = run(c, {folder / "", life > 0}, recorder);
    EXPECT_EQ(given.outcome.end == RunEnd::stopped, life < stops.size());
    EXPECT_EQ(recorder.resumed_from, life > 0 ? stops[life - 1] : -1);
    EXPECT_TRUE(recorder.messages.empty());
    given.reports.insert(given.reports.end(), recorder.reports.begin(), recorder.reports.end());
  }
  given.results = bytes_of(folder / "results.h5");
  given.sidecar = bytes_of(folder / "results.xdmf");
  return given;
}

inline void expect_equal(const Given& one, const Given& other) {
  EXPECT_EQ(one.outcome.end, other.outcome.end);
  EXPECT_EQ(one.outcome.failures, other.outcome.failures);
  ASSERT_EQ(one.reports.size(), other.reports.size());
  for (std::size_t i = 0; i < one.reports.size(); ++i)
    EXPECT_TRUE(equal_except_timing(one.reports[i], other.reports[i])) << "step " << i + 1;
  EXPECT_TRUE(one.results == other.results);
  EXPECT_TRUE(one.sidecar == other.sidecar);
}

}  // namespace dccast::casting::testing
