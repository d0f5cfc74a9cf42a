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

/// A figure that differed between two runs before their curls did.
struct Cause {
  std::string figure;    ///< "heat through the wide face"
  std::string unit;      ///< of the values below, as shown
  std::string sentence;  ///< "less heat through the wide face until 100 s (-22 %)"
  double onset = 0.0;    ///< place of the course where the difference begins [s] or [m]
  double share = 0.0;    ///< mean difference until the curls differ, of the figure's own scale [1]
  std::vector<double> first, other;  ///< (place of the course) [`unit`]
};

/// What the histories show of why two curls differ: up to three figures, those that differ most
/// relative to their own scale, in the order in which they begin to differ.
///
/// A figure counts only if it differs, on average up to the place where nine tenths of the
/// difference have come about, by more than 3 % of its scale, and begins to before half of the
/// difference has. That is what was different first; the runs cannot show more.
std::vector<Cause> causes_of(const Answer& first, const Answer& other,
                             const CurlDifference& difference);

/// "corner: -11.8 ± 1.0 mm, real. Less heat through the wide face until 100 s (-22 %), ...". Causes
/// are named for differences that are not within their error.
/// @param explained  causes were looked for: if there are none, the sentence says so
std::string sentence(const CurlDifference& difference, const std::vector<Cause>& causes,
                     bool explained = true);

}  // namespace dccast::client
