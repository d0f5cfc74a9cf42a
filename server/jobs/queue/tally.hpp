#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

/// How often a quantity was how large. Not safe to use from several threads.
struct Histogram {
  /// @param upper_ends  of the classes, ascending; what is larger counts beyond the last one
  explicit Histogram(std::span<const double> upper_ends)
      : bounds(upper_ends.begin(), upper_ends.end()), counts(upper_ends.size()) {}
  void add(double value);

  std::vector<double> bounds;
  std::vector<std::uint64_t> counts;  ///< of each class alone
  std::uint64_t count = 0;            ///< of all
  double sum = 0.0;
};

/// What has become of jobs since the daemon began.
struct TallyFigures {
  static constexpr std::array<double, 7> bounds_s{1, 10, 60, 600, 3600, 21600, 86400};
  Histogram wait_s{bounds_s};                   ///< from submission to the first start
  Histogram run_s{bounds_s};                    ///< of a job that has ended, in all its attempts
  std::map<std::string, double> processor_s;    ///< of ended jobs, by owner
  std::map<v1::JobState, std::uint64_t> ended;  ///< by how
  std::map<v1::Failure::Kind, std::uint64_t> failures;
  std::map<std::pair<std::string, v1::Finding::Severity>, std::uint64_t>
      findings;  ///< of ended jobs
};

/// Counts transitions of jobs. Safe to use from several threads.
class Tally {
public:
  /// @param job  as it is since it left the state `from`
  void count(const v1::Job& job, v1::JobState from);
  TallyFigures figures() const;

private:
  mutable std::mutex mutex_;
  TallyFigures figures_;
};

/// How long jobs take, learned from those that have succeeded: the estimate of a job's check, by
/// what the estimates of the last jobs were off. Not safe to use from several threads.
class Forecast {
public:
  void learn(const v1::Job& job);
  /// Wall time of a whole run [s]; 0: nothing is known.
  /// @param estimated_s  of its check; 0: not known
  double run_s(double estimated_s) const;
  /// What is left of a run [s]; 0: nothing is known. @param ran_s  in all its attempts so far
  double left_s(const v1::Job& job, double ran_s) const;
  /// When the job at a place of the queue starts, as if each before it took the same time
  /// [s from now].
  /// @param left_s    of the jobs that run
  /// @param place     1 is next
  /// @param each_s    of a job that waits
  static double start_s(std::vector<double> left_s, int capacity, int place, double each_s);

private:
  double taken_s_ = 0.0, estimated_s_ = 0.0;  ///< sums, of jobs long ago less
  double all_s_ = 0.0, all_ = 0.0;            ///< the same with those that had no estimate
};

}  // namespace dccast::jobs
