#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "client/model/answer.hpp"

namespace dccast::client {

/// A key that differs between the cases.
struct KeyDifference {
  std::string key;
  std::vector<std::string> values;  ///< (answer) as in a case file; "-" if the key is absent
};

/// Titles are ignored: they do not affect the results.
std::vector<KeyDifference> differing_keys(const std::vector<Answer>& answers);

/// The places at which two runs are compared, up to the end of the shorter one: times of the block,
/// or cast lengths where the two have not cast the same length at the same time.
struct Course {
  bool by_length = false;
  std::vector<double> at;  ///< steps of the first run and the common end, ascending [s] or [m]

  double length() const { return at.empty() ? 0.0 : at.back() - at.front(); }  ///< [s] or [m]
  std::string text(double place) const;  ///< "100 s" or "80 mm"
};
Course course_of(const CurlHistory& first, const CurlHistory& other);

/// A figure of a run along the course, linear between its steps; NaN outside the run.
/// @param value  (step of the history) [any unit]
/// @return       (place of the course) [unit of `value`]
std::vector<double> along(const Course& course, const CurlHistory& history,
                          const std::vector<double>& value);

/// Where the error of a difference comes from.
enum class ErrorSource {
  unknown,    ///< no pair was measured for such cases
  table,      ///< measured pairs of castings at two qualities (case_file::paired_error)
  qualities,  ///< the same two castings at another quality
};

/// Curl of a monitor in one answer less that of the first answer, both at the end of their course.
struct CurlDifference {
  std::string monitor;
  std::size_t answer = 0;  ///< index of the answer compared to the first
  Course course;
  std::vector<double> apart_m;          ///< other less first, along the course [m]
  double first_m = 0.0, other_m = 0.0;  ///< the two curls [m]
  double end_m = 0.0;                   ///< other less first [m]
  double largest_m = 0.0;               ///< the difference largest in magnitude [m]
  double largest_at = 0.0;              ///< its place in the course [s] or [m]
  /// What mesh and steps leave uncertain of end_m [m]. It is that of the pair: what both runs have
  /// in common cancels in their difference.
  std::optional<double> error_m;
  ErrorSource error_from = ErrorSource::unknown;

  bool none() const;  ///< the two curls are the same
  bool real() const;  ///< beyond its error
};

/// "real", "within its error", "of unknown error", "no difference".
const char* verdict(const CurlDifference& difference);

/// The differences for every monitor that both the first answer and another one have, in the order
/// of the answers. Answers that are the same casting as the first one or another one at another
/// quality give the errors of the differences.
/// @param companions  further runs at another quality, which are not compared
std::vector<CurlDifference> curl_differences(const std::vector<Answer>& answers,
                                             const std::vector<Answer>& companions = {});

}  // namespace dccast::client
