#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "server/judging/judged_run.hpp"

namespace dccast::judging {

/// A key that differs between the cases.
struct KeyDifference {
  std::string key;
  std::vector<std::string> values;  ///< (run) as in a case file; "-" if the key is absent
};

/// Titles are ignored: they do not affect the results.
std::vector<KeyDifference> differing_keys(const std::vector<JudgedRun>& runs);

/// The places at which two runs are compared: times of the block, or cast lengths where the two
/// have not cast the same length at the same time. They reach to the end of the shorter run, or of
/// the longer one where the curl of the shorter has settled.
struct Course {
  bool by_length = false;
  /// Steps of the first run, after its end those of the other one, and the common end, ascending
  /// [s] or [m].
  std::vector<double> places;

  /// From the first place to the last [s] or [m].
  double length() const { return places.empty() ? 0.0 : places.back() - places.front(); }
  const char* unit() const { return by_length ? "m" : "s"; }
  std::string text(double place) const;  ///< "100 s" or "80 mm"
};
Course common_course(const JudgedRun& first, const JudgedRun& other);

/// A figure of a run along the course, linear between its steps; NaN outside the run.
/// @param values  (step of the run) [any unit]
/// @return        (place of the course) [unit of `values`]
std::vector<double> along(const Course& course, const JudgedRun& run,
                          const std::vector<double>& values);
/// A curl of a run along the course [m]: one that has settled stays. Empty: no such monitor.
std::vector<double> curl_along(const Course& course, const JudgedRun& run,
                               const std::string& monitor);

/// Where the error of a difference comes from.
enum class ErrorSource {
  unknown,    ///< no pair was measured for such cases
  table,      ///< measured pairs of castings at two qualities (case_file::paired_error)
  qualities,  ///< the same two castings at another quality
};

enum class Verdict {
  no_difference,     ///< less than matters to a plant, 0.1 mm
  of_unknown_error,  ///< nothing is known of the error of such a difference
  within_its_error,
  real,  ///< larger than its error
};

/// Curl of a monitor in one run less that of the first run, both at the end of their course.
struct CurlDifference {
  std::string monitor;
  std::size_t run = 0;  ///< index of the run compared with the first
  Course course;
  std::vector<double> difference_m;  ///< other less first, along the course [m]
  double first_m = 0.0;              ///< curl of the first run at the end [m]
  double other_m = 0.0;              ///< curl of the other run there [m]
  double end_m = 0.0;                ///< other less first [m]
  double largest_m = 0.0;            ///< the difference largest in magnitude [m]
  double largest_at = 0.0;           ///< its place in the course [s] or [m]
  /// Discretisation error of end_m [m]. It is that of the pair: what both runs have in common
  /// cancels in their difference.
  std::optional<double> error_m;
  ErrorSource error_source = ErrorSource::unknown;

  Verdict verdict() const;
};

/// The differences of every monitor that both the first run and another one have, in the order of
/// the runs. Runs that are the same casting as the first one or another one at another quality give
/// the errors of the differences.
/// @param companions  further runs at another quality, which are not compared
std::vector<CurlDifference> curl_differences(const std::vector<JudgedRun>& runs,
                                             const std::vector<JudgedRun>& companions = {});

/// A figure that differed between two runs before their curls did.
struct Cause {
  std::string figure;    ///< "heat through the wide face"
  std::string unit;      ///< SI unit of the values below
  std::string sentence;  ///< "less heat through the wide face until 100 s (-22 %)"
  double onset = 0.0;    ///< place of the course where the difference begins [s] or [m]
  double share = 0.0;    ///< mean difference until the curls differ, of the figure's own scale [1]
  std::vector<double> first;  ///< (place of the course) [`unit`]
  std::vector<double> other;  ///< (place of the course) [`unit`]
};

/// What the histories show of why two curls differ: up to three figures, those that differ most
/// relative to their own scale, in the order in which they begin to differ.
///
/// A figure counts only if it differs, on average up to the place where nine tenths of the
/// difference have come about, by more than 3 % of its scale, and begins to before half of the
/// difference has. That is what was different first; the runs cannot show more.
std::vector<Cause> find_causes(const JudgedRun& first, const JudgedRun& other,
                               const CurlDifference& difference);

/// "corner at 145 s: -11.8 ± 1.0 mm, real. Less heat through the wide face until 100 s (-22 %),
/// ...". Causes are named for differences that are not within their error.
/// @param causes  empty: they were not looked for
std::string sentence(const CurlDifference& difference,
                     const std::optional<std::vector<Cause>>& causes);

}  // namespace dccast::judging
