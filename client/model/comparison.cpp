#include "client/model/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/core.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/values/interpolation.hpp"

namespace dccast::client {
namespace {

using Series = CurlHistory::Series;

const Series* series_of(const CurlHistory& history, const std::string& monitor) {
  const auto found = std::ranges::find(history.monitors, monitor, &Series::name);
  return found == history.monitors.end() ? nullptr : &*found;
}

/// Steps of a history at ascending places: of several at one place the last one.
struct Track {
  std::vector<double> at;
  std::vector<std::size_t> step;
};

Track track_of(const CurlHistory& history, bool by_length) {
  const std::vector<double>& place = by_length ? history.cast_length_m : history.time_s;
  Track track;
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (track.at.empty() || place[i] > track.at.back()) {
      track.at.push_back(place[i]);
      track.step.push_back(i);
    } else {
      track.step.back() = i;
    }
  }
  return track;
}

/// Whether two runs have not cast the same length at the same time.
bool lengths_differ(const CurlHistory& first, const CurlHistory& other) {
  constexpr double tolerance = 0.01;  // [1]
  const std::vector<double> theirs =
      values::at_instants(first.time_s, other.time_s, other.cast_length_m);
  double apart = 0.0, longest = 0.0;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    if (std::isnan(theirs[i])) continue;
    apart = std::max(apart, std::abs(theirs[i] - first.cast_length_m[i]));
    longest = std::max({longest, theirs[i], first.cast_length_m[i]});
  }
  return apart > tolerance * longest;
}

/// Curl of the second run less that of the first along a course [m]; empty if a monitor is missing.
std::vector<double> apart_along(const Course& course, const Answer& first, const Answer& other,
                                const std::string& monitor) {
  const Series* const mine = series_of(first.history, monitor);
  const Series* const theirs = series_of(other.history, monitor);
  if (mine == nullptr || theirs == nullptr) return {};
  const std::vector<double> before = along(course, first.history, mine->curl_m);
  std::vector<double> apart = along(course, other.history, theirs->curl_m);
  for (std::size_t i = 0; i < apart.size(); ++i) apart[i] -= before[i];
  return apart;
}

/// The same two castings at another quality: how much their difference changes from one quality to
/// the other, at most over the last quarter of the course, times the factor that Roache recommends
/// for two meshes (docs/error-bars.md) [m].
std::optional<double> error_from_qualities(const CurlDifference& difference, const Answer& first,
                                           const Answer& other,
                                           const std::vector<const Answer*>& runs) {
  constexpr double safety = 3.0, judged = 0.75;
  const Course& course = difference.course;
  const auto pair_of = [](const Answer& a, const Answer& b) {
    return a.description.quality() != b.description.quality() &&
           case_file::is_same_casting(a.description, b.description);
  };
  for (const Answer* mine : runs) {
    if (!pair_of(*mine, first)) continue;
    for (const Answer* theirs : runs) {
      if (!pair_of(*theirs, other) || theirs->description.quality() != mine->description.quality())
        continue;
      const auto here = apart_along(course, first, other, difference.monitor);
      const auto there = apart_along(course, *mine, *theirs, difference.monitor);
      double change = -1.0;
      for (std::size_t i = 0; i < there.size(); ++i)
        if (course.at[i] >= course.at.front() + judged * course.length())
          change = std::max(change, std::abs(there[i] - here[i]));
      if (change >= 0.0) return safety * change;
    }
  }
  return std::nullopt;
}

void find_error(CurlDifference& difference, const Answer& first, const Answer& other,
                const std::vector<const Answer*>& runs) {
  difference.error_m = error_from_qualities(difference, first, other, runs);
  if (difference.error_m) {
    difference.error_from = ErrorSource::qualities;
    return;
  }
  const auto paired = case_file::paired_error(first.description, other.description);
  if (!paired) return;
  difference.error_from = ErrorSource::table;
  difference.error_m =
      paired->of_curl * std::max(std::abs(difference.first_m), std::abs(difference.other_m)) +
      paired->of_difference * std::abs(difference.end_m);
}

std::optional<CurlDifference> difference_of(const Answer& first, const Answer& other,
                                            const std::string& monitor) {
  CurlDifference d;
  d.monitor = monitor;
  d.course = course_of(first.history, other.history);
  d.apart_m = apart_along(d.course, first, other, monitor);
  const std::vector<double>& apart = d.apart_m;
  if (apart.empty() || std::isnan(apart.back())) return std::nullopt;
  d.first_m = along(d.course, first.history, series_of(first.history, monitor)->curl_m).back();
  d.other_m = d.first_m + apart.back();
  d.end_m = apart.back();
  for (std::size_t i = 0; i < apart.size(); ++i) {
    if (!(std::abs(apart[i]) > std::abs(d.largest_m))) continue;
    d.largest_m = apart[i];
    d.largest_at = d.course.at[i];
  }
  return d;
}

/// A curl of round-off size: a monitor that stands on the block [m].
constexpr double least_m = 1e-6;

}  // namespace

std::string Course::text(double place) const {
  return by_length ? fmt::format("{:.0f} mm", 1e3 * place) : fmt::format("{:.0f} s", place);
}

Course course_of(const CurlHistory& first, const CurlHistory& other) {
  constexpr double same = 1e-6;  // [s] or [m]
  Course course;
  course.by_length = lengths_differ(first, other);
  const Track mine = track_of(first, course.by_length), theirs = track_of(other, course.by_length);
  if (mine.at.empty() || theirs.at.empty()) return course;
  const double end = std::min(mine.at.back(), theirs.at.back());
  for (const double at : mine.at)
    if (at >= theirs.at.front() - same && at < end - same) course.at.push_back(at);
  if (end >= std::max(mine.at.front(), theirs.at.front()) - same) course.at.push_back(end);
  return course;
}

std::vector<double> along(const Course& course, const CurlHistory& history,
                          const std::vector<double>& value) {
  const Track track = track_of(history, course.by_length);
  std::vector<double> kept;
  for (const std::size_t step : track.step) kept.push_back(value[step]);
  return values::at_instants(course.at, track.at, kept);
}

bool CurlDifference::none() const {
  return std::abs(end_m) < least_m && std::abs(largest_m) < least_m;
}

bool CurlDifference::real() const {
  return error_m && std::abs(end_m) > std::max(*error_m, least_m);
}

const char* verdict(const CurlDifference& difference) {
  if (difference.none()) return "no difference";
  if (!difference.error_m) return "of unknown error";
  return difference.real() ? "real" : "within its error";
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

std::vector<CurlDifference> curl_differences(const std::vector<Answer>& answers,
                                             const std::vector<Answer>& companions) {
  std::vector<const Answer*> runs;
  for (const auto* list : {&answers, &companions})
    for (const Answer& answer : *list) runs.push_back(&answer);
  std::vector<CurlDifference> differences;
  const Answer& first = answers.front();
  for (std::size_t i = 1; i < answers.size(); ++i)
    for (const Series& mine : first.history.monitors) {
      auto difference = difference_of(first, answers[i], mine.name);
      if (!difference) continue;
      difference->answer = i;
      find_error(*difference, first, answers[i], runs);
      differences.push_back(std::move(*difference));
    }
  return differences;
}

}  // namespace dccast::client
