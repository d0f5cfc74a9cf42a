#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <vector>

#include "core/casting/simulation.hpp"

namespace dccast::regression {

struct Recorder : casting::StepObserver {
  casting::Order on_step(const results::StepReport& report) override {
    reports.push_back(report);
    return casting::Order::go_on;
  }
  void on_resumed(std::int64_t, double) override {}
  void on_message(std::string_view) override {}
  std::vector<results::StepReport> reports;
};

struct Outcome {
  casting::RunOutcome outcome;
  std::vector<results::StepReport> reports;
};

inline Outcome outcome_of(const casting::Case& c) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("dccast-regression-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  Recorder recorder;
  const auto outcome = casting::run(c, {folder, false}, recorder);
  std::filesystem::remove_all(folder);
  return {outcome, recorder.reports};
}

inline std::vector<results::StepReport> run(const casting::Case& c) {
  const auto [outcome, reports] = outcome_of(c);
  EXPECT_EQ(outcome.end, casting::RunEnd::succeeded) << casting::in_words(outcome.failures);
  return reports;
}

/// Over all steps and monitors [m]; infinite where the steps are not the same.
inline double largest_difference(const std::vector<results::StepReport>& one,
                                 const std::vector<results::StepReport>& other) {
  if (one.size() != other.size()) return INFINITY;
  double largest = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    if (one[i].time != other[i].time) return INFINITY;
    for (std::size_t m = 0; m < one[i].monitor_displacement.size(); ++m) {
      for (std::size_t d = 0; d < 2; ++d) {
        largest = std::max(largest, std::abs(one[i].monitor_displacement[m][d] -
                                             other[i].monitor_displacement[m][d]));
      }
    }
  }
  return largest;
}

}  // namespace dccast::regression
