#include "server/judging/comparison.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/fingerprint.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/values/interpolation.hpp"
#include "server/judging/settling.hpp"

namespace dccast::judging {
namespace {

/// The least difference of a curl that matters to a plant [m].
constexpr double matters_m = 1e-4;

/// Steps of a run at ascending places; of several at one place, as during the hold, the last one.
struct Track {
  std::vector<double> places;
  std::vector<std::size_t> steps;
};

Track track_of(const JudgedRun& run, bool by_length) {
  const std::vector<double> places = by_length ? run.cast_length_m() : run.time_s();
  Track track;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (track.places.empty() || places[i] > track.places.back()) {
      track.places.push_back(places[i]);
      track.steps.push_back(i);
    } else {
      track.steps.back() = i;
    }
  }
  return track;
}

/// Whether two runs have not cast the same length at the same time.
bool lengths_differ(const JudgedRun& first, const JudgedRun& other) {
  constexpr double tolerance = 0.01;  // [1]
  const std::vector<double> mine = first.cast_length_m();
  const std::vector<double> theirs =
      values::at_instants(first.time_s(), other.time_s(), other.cast_length_m());

  double difference = 0.0;
  double longest = 0.0;
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    if (std::isnan(theirs[i])) continue;
    difference = std::max(difference, std::abs(theirs[i] - mine[i]));
    longest = std::max({longest, theirs[i], mine[i]});
  }
  return difference > tolerance * longest;
}

/// Curl of the second run less that of the first along a course [m]; empty if a monitor is missing.
std::vector<double> differences_along(const Course& course, const JudgedRun& first,
                                      const JudgedRun& other, const std::string& monitor) {
  const std::vector<double> before = curl_along(course, first, monitor);
  std::vector<double> difference = curl_along(course, other, monitor);
  if (before.empty() || difference.empty()) return {};
  std::ranges::transform(difference, before, difference.begin(), std::minus());
  return difference;
}

using RunPointers = std::vector<const JudgedRun*>;

/// The same casting at another quality.
bool is_companion(const JudgedRun& candidate, const JudgedRun& run) {
  const auto casting = [](const JudgedRun& judged) {
    return case_file::fingerprint(judged.description, case_file::Same::casting);
  };
  return candidate.description.quality() != run.description.quality() &&
         casting(candidate) == casting(run);
}

/// The same two castings at another quality: how much their difference changes from one quality to
/// the other, at most over the last quarter of the course, times the factor that Roache recommends
/// for two meshes (docs/error-bars.md) [m].
std::optional<double> error_by_companions(const CurlDifference& difference, const JudgedRun& mine,
                                          const JudgedRun& theirs) {
  constexpr double safety = 3.0;
  constexpr double judged_from = 0.75;  // of the course
  const Course& course = difference.course;
  const auto there = differences_along(course, mine, theirs, difference.monitor);

  std::optional<double> change;
  for (std::size_t i = 0; i < there.size(); ++i) {
    if (course.places[i] < course.places.front() + judged_from * course.length()) continue;
    const double here = difference.difference_m[i];
    change = std::max(change.value_or(0.0), std::abs(there[i] - here));
  }
  return change ? std::optional(safety * *change) : std::nullopt;
}

std::optional<double> error_from_qualities(const CurlDifference& difference, const JudgedRun& first,
                                           const JudgedRun& other, const RunPointers& runs) {
  for (const JudgedRun* mine : runs) {
    if (!is_companion(*mine, first)) continue;
    for (const JudgedRun* theirs : runs) {
      if (theirs->description.quality() != mine->description.quality()) continue;
      if (!is_companion(*theirs, other)) continue;
      if (const auto error = error_by_companions(difference, *mine, *theirs)) return error;
    }
  }
  return std::nullopt;
}

void find_error(CurlDifference& difference, const JudgedRun& first, const JudgedRun& other,
                const RunPointers& runs) {
  difference.error_m = error_from_qualities(difference, first, other, runs);
  if (difference.error_m) {
    difference.error_source = ErrorSource::qualities;
    return;
  }

  const auto paired = case_file::paired_error(first.description, other.description);
  if (!paired) return;
  difference.error_source = ErrorSource::table;
  difference.error_m =
      paired->of_curl * std::max(std::abs(difference.first_m), std::abs(difference.other_m)) +
      paired->of_difference * std::abs(difference.end_m);
}

std::optional<CurlDifference> difference_of(const JudgedRun& first, const JudgedRun& other,
                                            const std::string& monitor) {
  CurlDifference found;
  found.monitor = monitor;
  found.course = common_course(first, other);
  found.difference_m = differences_along(found.course, first, other, monitor);
  const std::vector<double>& difference = found.difference_m;
  if (difference.empty() || std::isnan(difference.back())) return std::nullopt;

  found.first_m = curl_along(found.course, first, monitor).back();
  found.other_m = found.first_m + difference.back();
  found.end_m = difference.back();

  for (std::size_t i = 0; i < difference.size(); ++i) {
    if (!(std::abs(difference[i]) > std::abs(found.largest_m))) continue;
    found.largest_m = difference[i];
    found.largest_at = found.course.places[i];
  }
  return found;
}

}  // namespace

std::string Course::text(double place) const {
  return by_length ? fmt::format("{:.0f} mm", 1e3 * place) : fmt::format("{:.0f} s", place);
}

Course common_course(const JudgedRun& first, const JudgedRun& other) {
  constexpr double same = 1e-6;  // [s] or [m]
  Course course;
  course.by_length = lengths_differ(first, other);
  const std::vector<double> mine = track_of(first, course.by_length).places;
  const std::vector<double> theirs = track_of(other, course.by_length).places;
  if (mine.empty() || theirs.empty()) return course;

  const bool first_is_shorter = mine.back() < theirs.back();
  const bool is_held = has_settled(first_is_shorter ? first : other);
  const auto [shorter_end, longer_end] = std::minmax(mine.back(), theirs.back());
  const double end = is_held ? longer_end : shorter_end;

  for (const double place : mine)
    if (place >= theirs.front() - same && place < end - same) course.places.push_back(place);
  for (const double place : theirs)
    if (place > mine.back() + same && place < end - same) course.places.push_back(place);
  if (end >= std::max(mine.front(), theirs.front()) - same) course.places.push_back(end);
  return course;
}

std::vector<double> along(const Course& course, const JudgedRun& run,
                          const std::vector<double>& values) {
  const Track track = track_of(run, course.by_length);
  std::vector<double> kept;
  for (const std::size_t step : track.steps) kept.push_back(values[step]);
  return values::at_instants(course.places, track.places, kept);
}

std::vector<double> curl_along(const Course& course, const JudgedRun& run,
                               const std::string& monitor) {
  const std::vector<double> curl_m = run.curl_m(monitor);
  if (curl_m.empty()) return {};

  std::vector<double> values = along(course, run, curl_m);
  const double end = track_of(run, course.by_length).places.back();
  const auto beyond = std::ranges::upper_bound(course.places, end) - course.places.begin();
  if (beyond < std::ssize(values) && has_settled(run))
    std::fill(values.begin() + beyond, values.end(), curl_m.back());
  return values;
}

Verdict CurlDifference::verdict() const {
  if (std::abs(end_m) < matters_m) return Verdict::no_difference;
  if (!error_m) return Verdict::of_unknown_error;
  return std::abs(end_m) > *error_m ? Verdict::real : Verdict::within_its_error;
}

std::vector<KeyDifference> differing_keys(const std::vector<JudgedRun>& runs) {
  std::vector<KeyDifference> keys;
  std::map<std::string, std::size_t> row_of;
  for (std::size_t i = 0; i < runs.size(); ++i)
    for (const auto& [key, value] : case_file::key_values(runs[i].description)) {
      const auto [row, added] = row_of.try_emplace(key, keys.size());
      if (added) keys.push_back({key, std::vector<std::string>(runs.size(), "-")});
      keys[row->second].values[i] = value;
    }

  const auto is_common = [](const KeyDifference& row) {
    return std::ranges::all_of(row.values,
                               [&](const std::string& value) { return value == row.values[0]; });
  };
  std::erase_if(keys, [&](const auto& row) { return row.key == "title" || is_common(row); });
  return keys;
}

std::vector<CurlDifference> curl_differences(const std::vector<JudgedRun>& runs,
                                             const std::vector<JudgedRun>& companions) {
  RunPointers all;
  for (const auto* list : {&runs, &companions})
    for (const JudgedRun& run : *list) all.push_back(&run);

  std::vector<CurlDifference> differences;
  const JudgedRun& first = runs.front();
  for (std::size_t i = 1; i < runs.size(); ++i)
    for (const std::string& monitor : first.monitors()) {
      auto difference = difference_of(first, runs[i], monitor);
      if (!difference) continue;
      difference->run = i;
      find_error(*difference, first, runs[i], all);
      differences.push_back(std::move(*difference));
    }
  return differences;
}

}  // namespace dccast::judging
