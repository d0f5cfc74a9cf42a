#include "client/model/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "client/model/answer.hpp"
#include "proto/case_file/case_file.hpp"

namespace dccast::client {
namespace {

using Series = CurlHistory::Series;

const Series* series_of(const Answer& answer, const std::string& monitor) {
  const auto& all = answer.history.monitors;
  const auto found = std::ranges::find(all, monitor, &Series::name);
  return found == all.end() ? nullptr : &*found;
}

/// Value at a time between the first and the last instant, linear between two.
double value_at(const std::vector<double>& time_s, const std::vector<double>& value, double at_s) {
  const auto right = static_cast<std::size_t>(std::lower_bound(time_s.begin(), time_s.end(), at_s) -
                                              time_s.begin());
  if (right == 0 || time_s[right] == at_s) return value[right];
  const double share = (at_s - time_s[right - 1]) / (time_s[right] - time_s[right - 1]);
  return value[right - 1] + share * (value[right] - value[right - 1]);
}

/// Compares at the times of the first answer that the other one covers.
void find_largest(const Answer& first, const Series& mine, const Answer& other,
                  const Series& theirs, CurlDifference& difference) {
  const std::vector<double>& time_s = other.history.time_s;
  for (std::size_t i = 0; i < first.history.time_s.size(); ++i) {
    const double at_s = first.history.time_s[i];
    if (at_s < time_s.front() || at_s > time_s.back()) continue;
    const double apart_m = value_at(time_s, theirs.curl_m, at_s) - mine.curl_m[i];
    if (!(std::abs(apart_m) > std::abs(difference.largest_m))) continue;
    difference.largest_m = apart_m;
    difference.largest_time_s = at_s;
  }
}

}  // namespace

Weight weight_of(const CurlDifference& difference) {
  if (!difference.uncertainty_m || !difference.first_uncertainty_m) return Weight::unknown;
  const double size = std::abs(difference.end_m);
  // A monitor in contact with the block has an error band of zero width and a curl of round-off
  // size.
  constexpr double least = 1e-6;  // [m]
  const double mine = std::max(*difference.first_uncertainty_m, least);
  const double theirs = std::max(*difference.uncertainty_m, least);
  if (size < std::min(mine, theirs)) return Weight::below_either;
  return size < mine + theirs ? Weight::below_both : Weight::beyond_errors;
}

const char* in_words(Weight weight) {
  switch (weight) {
    case Weight::below_either:
      return "smaller than the discretisation error of either run";
    case Weight::below_both:
      return "smaller than the discretisation errors of both runs together";
    case Weight::beyond_errors:
      return "larger than the discretisation errors of both runs together";
    default:
      return "no discretisation error is known of such a case";
  }
}

std::vector<KeyDifference> differing_keys(const std::vector<Answer>& answers) {
  std::vector<KeyDifference> keys;
  std::map<std::string, std::size_t> place;
  for (std::size_t i = 0; i < answers.size(); ++i)
    for (const auto& [key, value] : case_file::key_values(answers[i].description)) {
      const auto [at, added] = place.try_emplace(key, keys.size());
      if (added) keys.push_back({key, std::vector<std::string>(answers.size(), "-")});
      keys[at->second].values[i] = value;
    }
  std::erase_if(keys, [](const KeyDifference& row) {
    return row.key == "title" || std::ranges::count(row.values, row.values.front()) ==
                                     static_cast<std::ptrdiff_t>(row.values.size());
  });
  return keys;
}

std::vector<CurlDifference> curl_differences(const std::vector<Answer>& answers) {
  std::vector<CurlDifference> differences;
  const Answer& first = answers.front();
  for (std::size_t i = 1; i < answers.size(); ++i)
    for (const Series& mine : first.history.monitors) {
      const Series* const theirs = series_of(answers[i], mine.name);
      if (theirs == nullptr || theirs->curl_m.empty() || mine.curl_m.empty()) continue;
      CurlDifference difference;
      difference.monitor = mine.name;
      difference.answer = i;
      difference.end_m = theirs->curl_m.back() - mine.curl_m.back();
      find_largest(first, mine, answers[i], *theirs, difference);
      difference.first_uncertainty_m = discretisation_error(first.description, mine.curl_m.back());
      difference.uncertainty_m =
          discretisation_error(answers[i].description, theirs->curl_m.back());
      differences.push_back(std::move(difference));
    }
  return differences;
}

}  // namespace dccast::client
