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

/// Frequency distribution of a quantity. Not safe to use from several threads.
struct Histogram {
  /// @param upper_ends  of the classes, ascending; larger values count in `count` only
  explicit Histogram(std::span<const double> upper_ends)
      : bounds(upper_ends.begin(), upper_ends.end()), counts(upper_ends.size()) {}
  /// Counts a value in its bucket.
  void add(double value);

  /// Upper bounds of the buckets, ascending; larger values count in the total only.
  std::vector<double> bounds;
  std::vector<std::uint64_t> counts;  ///< of each class alone
  std::uint64_t count = 0;            ///< of all
  double sum = 0.0;
};

/// Statistics of jobs since the start of the daemon.
struct TallyFigures {
  /// Bounds for waiting and run times [s].
  static constexpr std::array<double, 7> bounds_s{1, 10, 60, 600, 3600, 21600, 86400};
  Histogram wait_s{bounds_s};                   ///< from submission to the first start
  Histogram run_s{bounds_s};                    ///< of an ended job, over all its attempts
  std::map<std::string, double> processor_s;    ///< of ended jobs, by owner
  std::map<v1::JobState, std::uint64_t> ended;  ///< by final state
  std::map<v1::Finding::Kind, std::uint64_t> failures;
  std::map<std::pair<std::string, v1::Finding::Severity>, std::uint64_t>
      findings;  ///< of ended jobs
};

/// Counts transitions of jobs. Safe to use from several threads.
class Tally {
public:
  /// @param job  after its transition from the state `from`
  void count(const v1::Job& job, v1::JobState from);
  /// A copy of the counts so far.
  TallyFigures figures() const;

private:
  mutable std::mutex mutex_;
  TallyFigures figures_;
};

/// Predicts how long jobs take: the estimate of a job's check, corrected by the mean error of the
/// estimates of recent jobs. Not safe to use from several threads.
class Forecast {
public:
  /// Counts a job that has ended.
  void learn(const v1::Job& job);
  /// Wall time of a whole run [s]; 0: not known.
  /// @param estimated_s  of its check; 0: not known
  double run_s(double estimated_s) const;
  /// Remaining time of a run [s]; 0: not known. @param ran_s  time of all its attempts so far
  double remaining_s(const v1::Job& job, double ran_s) const;
  /// Start of the job at a place of the queue, if each job before it takes the same time
  /// [s from now].
  /// @param remaining_s  of the running jobs
  /// @param place        1 is next
  /// @param each_s       run time of a waiting job
  static double start_s(std::vector<double> remaining_s, int capacity, int place, double each_s);

private:
  // Sums in which older jobs have less weight.
  double taken_s_ = 0.0;      ///< run time of jobs that had an estimate
  double estimated_s_ = 0.0;  ///< their estimates
  double total_s_ = 0.0;      ///< run time of all jobs
  double weight_ = 0.0;       ///< number of all jobs
};

}  // namespace dccast::jobs
