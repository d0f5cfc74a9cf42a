#include "server/judging/judged_comparison.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "proto/case_file/quality.hpp"
#include "server/judging/judgement.hpp"

namespace dccast::judging {
namespace {

using Runs = std::vector<JudgedRun>;
using Differences = std::vector<CurlDifference>;

constexpr double shown_m = 1e-6;  ///< curls are shown in thousandths of a millimetre
constexpr int most_points = 60'000;

std::string numbered(const Runs& runs, std::size_t run) {
  return fmt::format("{} {}", run + 1, runs[run].name);
}

/// A difference with what differed before it.
struct Explained {
  const CurlDifference& difference;
  /// Of the monitor that differs most between two runs; of others they are not looked for.
  std::optional<std::vector<Cause>> causes;
};

std::vector<Explained> explanations(const Runs& runs, const Differences& differences) {
  std::vector<Explained> explained;
  for (const CurlDifference& difference : differences) {
    const bool largest = std::ranges::none_of(differences, [&](const CurlDifference& other) {
      return other.run == difference.run && std::abs(other.end_m) > std::abs(difference.end_m);
    });
    explained.push_back({difference, std::nullopt});
    if (largest)
      explained.back().causes = find_causes(runs.front(), runs[difference.run], difference);
  }
  return explained;
}

/// What a reader knows before the differences: runs without a result, and runs of two qualities.
void add_reservations(const Runs& runs, v1::Judgement& judgement) {
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (runs[i].failed)
      judgement.add_sentences(
          fmt::format("run {} failed at {:.0f} s and has no curl: it is compared up to there.",
                      i + 1, runs[i].steps.back().time_s()));

  // A case that gives mesh and steps itself has the same ones at every quality.
  const v1::Case& first = runs[0].description;
  if (std::ranges::any_of(runs, [&](const JudgedRun& run) {
        return run.description.quality() != first.quality() &&
               run.description.mesh().SerializeAsString() != first.mesh().SerializeAsString();
      }))
    judgement.add_sentences(
        "The runs have different qualities: part of each difference is that of mesh and steps.");
}

/// Differences that matter; of a run without one that there is none.
void add_sentences(const Runs& runs, const std::vector<Explained>& explained,
                   v1::Judgement& judgement) {
  for (std::size_t run = 1; run < runs.size(); ++run) {
    const CurlDifference* last = nullptr;
    bool differs = false;
    for (const auto& [difference, causes] : explained) {
      if (difference.run != run) continue;
      last = &difference;
      if (difference.verdict() == Verdict::no_difference) continue;
      differs = true;
      judgement.add_sentences(fmt::format("run {}, {}", run + 1, sentence(difference, causes)));
    }
    if (last != nullptr && !differs)
      judgement.add_sentences(fmt::format("run {}: no difference of 0.1 mm or more at {}.", run + 1,
                                          last->course.text(last->course.places.back())));
  }
}

void add_keys(const Runs& runs, v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, "keys", "what differs in the cases");
  const auto keys = differing_keys(runs);
  if (keys.empty()) {
    table.set_note("the cases do not differ");
    return;
  }

  add_columns(table, {text_column("key", "key")});
  for (std::size_t run = 1; run <= runs.size(); ++run)
    add_columns(table, {text_column(fmt::format("run_{}", run), std::to_string(run))});
  for (const KeyDifference& row : keys) {
    v1::Table::Row& added = *table.add_rows();
    *added.add_cells() = text_cell(row.key);
    for (const std::string& value : row.values) *added.add_cells() = case_cell(value);
  }
}

/// Monitors of all runs, in order of first appearance.
std::vector<std::string> monitors_of(const Runs& runs) {
  std::vector<std::string> names;
  for (const JudgedRun& run : runs)
    for (const std::string& name : run.monitors())
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  return names;
}

/// Whether a chart of this monitor would show anything but zero.
bool has_curl(const Runs& runs, const std::string& monitor) {
  constexpr double least_shown_m = 5e-6;
  return std::ranges::any_of(runs, [&](const JudgedRun& run) {
    const auto curl = run.curl_m(monitor);
    return std::ranges::any_of(curl, [](double y) { return std::abs(y) >= least_shown_m; });
  });
}

/// @param by_length  a difference of this monitor is taken at equal cast length
void add_curls(const Runs& runs, const std::string& monitor, bool by_length,
               v1::Judgement& judgement) {
  v1::Chart& chart =
      add_chart(judgement, "curl", "curl of " + monitor,
                {by_length ? "cast length" : "time", by_length ? "m" : "s", "curl", "m"},
                v1::JudgementPart::ANYWHERE);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto curl = runs[i].curl_m(monitor);
    if (curl.empty()) continue;
    v1::Chart::Line& line = add_line(chart, numbered(runs, i),
                                     by_length ? runs[i].cast_length_m() : runs[i].time_s(), curl);
    if (const auto error = case_file::monitor_error(runs[i].description, monitor))
      add_band(line, *error);
  }
}

/// The axis of a chart of differences is theirs: beside whole curls an effect of a millimetre is
/// not seen. Its region is what is within the error.
/// @param by_length  the differences that are taken at equal cast length, else those at equal time
void add_differences_chart(const Runs& runs, const Differences& differences,
                           const std::string& monitor, bool by_length, v1::Judgement& judgement) {
  std::vector<const CurlDifference*> shown;
  for (const CurlDifference& row : differences)
    if (row.monitor == monitor && row.course.by_length == by_length &&
        std::abs(row.largest_m) > shown_m)
      shown.push_back(&row);
  if (shown.empty()) return;

  v1::Chart& chart = add_chart(
      judgement, "difference", "differences of " + monitor,
      {by_length ? "cast length" : "time", by_length ? "m" : "s", "curl less that of run 1", "m"});
  double error_m = 0.0;
  for (const CurlDifference* row : shown) {
    add_line(chart, numbered(runs, row->run), row->course.places, row->difference_m);
    error_m = std::max(error_m, row->error_m.value_or(0.0));
  }
  if (error_m <= 0.0) return;
  chart.mutable_region()->set_low(-error_m);
  chart.mutable_region()->set_high(error_m);
  chart.mutable_region()->set_name("within the error of a difference at the end");
}

v1::Table::Column curl_column(const std::string& key, const std::string& heading) {
  return number_column(key, heading, "m", shown_m);
}

std::string code_of(Verdict verdict) {
  std::string code = words(verdict);
  std::ranges::replace(code, ' ', '_');
  return code;
}

/// Of each difference the curl of the first run and that of the other one, each with its own error;
/// beside the other one the difference with that of the pair.
void add_differences_table(const Runs& runs, const Differences& differences,
                           v1::Judgement& judgement) {
  static constexpr const char* sources[] = {"unknown", "table", "qualities"};
  v1::Table& table = add_table(judgement, "differences", "differences of the curl");
  add_columns(table, {
                         text_column("monitor", "monitor"),
                         text_column("run", "run"),
                         curl_column("curl", "curl"),
                         text_column("at", "at"),
                         curl_column("difference", "less 1"),
                         curl_column("largest", "largest"),
                         text_column("largest_at", "at"),
                         text_column("verdict", "verdict"),
                         text_column("error_from", ""),
                     });
  for (const int column : {2, 4}) table.mutable_columns(column)->set_has_error(true);
  for (const int column : {4, 5}) table.mutable_columns(column)->set_is_signed(true);

  for (const CurlDifference& row : differences) {
    const auto own_curl = [&](const JudgedRun& run, double curl_m) {
      const auto error = case_file::monitor_error(run.description, row.monitor);
      return curl_cell(curl_m,
                       error ? std::optional(case_file::curl_error(*error, curl_m)) : std::nullopt);
    };
    // The three figures of a row add up as they are shown.
    const auto shown = [](double curl_m) { return shown_m * std::round(curl_m / shown_m); };
    const double end_m = shown(row.other_m) - shown(row.first_m);
    const v1::Cell monitor = text_cell(row.monitor);
    const v1::Cell end = number_cell(row.course.places.back(), row.course.unit());
    add_row(table, {monitor, number_cell(1), own_curl(runs.front(), row.first_m), end});
    add_row(table,
            {monitor, number_cell(static_cast<double>(row.run + 1)),
             own_curl(runs[row.run], row.other_m), end, number_cell(end_m, row.error_m),
             number_cell(row.largest_m == row.end_m ? end_m : row.largest_m),
             number_cell(row.largest_at, row.course.unit()), code_cell(code_of(row.verdict())),
             code_cell(sources[static_cast<int>(row.error_source)])});
  }
}

/// The figures that differed before the curl, in both runs.
void add_causes(const Runs& runs, const std::vector<Explained>& explained,
                v1::Judgement& judgement) {
  for (const auto& [difference, causes] : explained) {
    const Course& course = difference.course;
    const bool told = difference.verdict() != Verdict::within_its_error;
    for (const Cause& cause : told ? causes.value_or(std::vector<Cause>{}) : std::vector<Cause>{}) {
      v1::Chart& chart = add_chart(
          judgement, "cause", cause.sentence,
          {course.by_length ? "cast length" : "time", course.unit(), cause.figure, cause.unit});
      add_line(chart, numbered(runs, 0), course.places, cause.first);
      add_line(chart, numbered(runs, difference.run), course.places, cause.other);
    }
  }
}

}  // namespace

v1::Judgement judge_comparison(const Runs& runs, const Runs& companions) {
  const Differences differences = curl_differences(runs, companions);
  const std::vector<Explained> explained = explanations(runs, differences);
  const std::vector<std::string> monitors = monitors_of(runs);

  v1::Judgement judgement;
  judgement.set_heading(fmt::format("{} runs", runs.size()));
  add_reservations(runs, judgement);
  add_sentences(runs, explained, judgement);
  add_keys(runs, judgement);
  for (const std::string& monitor : monitors)
    if (has_curl(runs, monitor)) {
      const bool by_length = std::ranges::any_of(differences, [&](const CurlDifference& row) {
        return row.monitor == monitor && row.course.by_length;
      });
      add_curls(runs, monitor, by_length, judgement);
    }
  for (const std::string& monitor : monitors)
    for (const bool by_length : {false, true})
      add_differences_chart(runs, differences, monitor, by_length, judgement);
  add_differences_table(runs, differences, judgement);
  add_causes(runs, explained, judgement);
  limit_points(judgement, most_points);
  return judgement;
}

}  // namespace dccast::judging
