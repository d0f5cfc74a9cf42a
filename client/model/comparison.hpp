#pragma once

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

/// Curl of a monitor in one answer compared to the first answer.
struct CurlDifference {
  std::string monitor;
  std::size_t answer = 0;  ///< index of the answer compared to the first
  double end_m = 0.0;      ///< curl at the end minus that of the first answer [m]
  double largest_m = 0.0;  ///< difference largest in magnitude over their common time [m]
  double largest_time_s = 0.0;
  std::optional<double> uncertainty_m, first_uncertainty_m;  ///< of the two curls at the end [m]
};

/// Significance of a difference.
enum class Weight {
  unknown,        ///< the error of at least one of the two is unknown
  below_either,   ///< smaller than the discretisation error of either run
  below_both,     ///< smaller than the sum of both errors
  beyond_errors,  ///< larger than that
};

Weight weight_of(const CurlDifference& difference);

/// "smaller than the discretisation error of either run", ...
const char* in_words(Weight weight);

/// Titles are ignored: they do not affect the results.
std::vector<KeyDifference> differing_keys(const std::vector<Answer>& answers);

/// The differences for every monitor that both the first answer and another one have, in the order
/// of the answers.
std::vector<CurlDifference> curl_differences(const std::vector<Answer>& answers);

}  // namespace dccast::client
