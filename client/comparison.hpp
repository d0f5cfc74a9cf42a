#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/query.hpp"

namespace dccast::client {

/// A key that is not the same in all of the cases.
struct KeyDifference {
  std::string key;
  std::vector<std::string> values;  ///< by answer, as in a case file; "-" where it has none
};

/// What one answer says of a monitor beside what the first one says.
struct CurlDifference {
  std::string monitor;
  std::size_t answer = 0;  ///< index of the other one
  double end_m = 0.0;      ///< curl at the end, less that of the first
  double largest_m = 0.0;  ///< difference that is largest in size, over the time both have
  double largest_time_s = 0.0;
  std::optional<double> uncertainty_m, first_uncertainty_m;  ///< of the two curls at the end
};

/// Whether a difference says anything.
enum class Weight {
  unknown,        ///< no error is known of one of the two
  below_either,   ///< smaller than the discretisation error of either run
  below_both,     ///< smaller than the two errors together
  beyond_errors,  ///< larger
};

Weight weight_of(const CurlDifference& difference);

/// "smaller than the discretisation error of either run", ...
const char* in_words(Weight weight);

/// Titles are left out: they decide nothing.
std::vector<KeyDifference> differing_keys(const std::vector<Answer>& answers);

/// Of every monitor that the first answer and another one have, in the order of the answers.
std::vector<CurlDifference> curl_differences(const std::vector<Answer>& answers);

}  // namespace dccast::client
