// The judgement of a single run: sentences, figures of its last step, and charts of its curls. The
// other charts are in run_histories.cpp and frame_judgement.cpp, the facts in run_facts.cpp.
#include "server/judging/run_judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "proto/values/interpolation.hpp"
#include "server/judging/judged_study.hpp"
#include "server/judging/judgement.hpp"
#include "server/judging/settling.hpp"

namespace dccast::judging {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();
constexpr double curl_resolution_m = 1e-5;  ///< smallest difference that is shown
constexpr int most_points = 60'000;

bool is_quarter(const JudgedRun& run) {
  return run.description.section().kind() == v1::Section::QUARTER_SLAB;
}

/// What a curl tends to as cells and time steps go to zero.
struct Limit {
  double curl_m;
  double uncertainty_m;  ///< half the width of the interval around it
  bool is_extrapolated;  ///< else it is the curl of the finest run
};

/// The curl of one monitor.
struct MonitoredCurl {
  std::string monitor;
  std::vector<double> curl_m;  ///< (step) NaN where it is not reported
  double end_m;
  std::optional<Limit> limit;  ///< of the curl at the end, from the study of the run
  /// Error of the curl at the end: from the study, else from the quality of the case.
  std::optional<case_file::CurlError> error;
};

std::optional<Limit> find_limit(const v1::StudyResult& study, const std::string& monitor,
                                double time_s) {
  const auto found = std::ranges::find(
      study.limits(), monitor,
      [](const v1::StudyResult::Limit& limit) { return limit.curve().monitor(); });
  if (found == study.limits().end()) return std::nullopt;

  const v1::CurlCurve& curve = found->curve();
  const auto at_end = [&](const google::protobuf::RepeatedField<double>& values) {
    return values::at_instants({time_s}, {curve.time_s().begin(), curve.time_s().end()},
                               {values.begin(), values.end()})
        .front();
  };
  const Limit limit{at_end(curve.curl_m()), at_end(curve.uncertainty_m()), found->has_order()};
  return std::isfinite(limit.curl_m) ? std::optional(limit) : std::nullopt;
}

/// The error that the quality of the case leaves.
std::optional<case_file::CurlError> reported_error(const v1::StepReport& step,
                                                   const std::string& monitor) {
  const v1::MonitorValue& found = figures::monitor_of(step, monitor);
  if (!found.has_curl_upper_error_m()) return std::nullopt;
  return case_file::CurlError{found.curl_lower_error_m(), found.curl_upper_error_m()};
}

std::vector<MonitoredCurl> monitored_curls(const RunToJudge& judged) {
  const JudgedRun& run = judged.run;
  const v1::StepReport& last = run.steps.back();

  std::vector<MonitoredCurl> curls;
  for (const std::string& monitor : run.monitors()) {
    MonitoredCurl& curl = curls.emplace_back();
    curl.monitor = monitor;
    curl.curl_m = run.curl_m(monitor);
    curl.end_m = curl.curl_m.back();
    curl.limit = find_limit(judged.refinement, monitor, last.time_s());
    curl.error = reported_error(last, monitor);

    // The distance to the limit, and the uncertainty of the limit itself.
    if (curl.limit && std::isfinite(curl.end_m)) {
      const double error_m = std::abs(curl.end_m - curl.limit->curl_m) + curl.limit->uncertainty_m;
      curl.error = case_file::CurlError{error_m, error_m};
    }
  }
  return curls;
}

/// The curl that is judged; null where none is reported.
const MonitoredCurl* find_judged(const JudgedRun& run, const std::vector<MonitoredCurl>& curls) {
  const v1::MonitorValue* const judged = figures::judged_curl(run.steps.back());
  if (judged == nullptr) return nullptr;
  const auto found = std::ranges::find(curls, judged->name(), &MonitoredCurl::monitor);
  return found == curls.end() ? nullptr : &*found;
}

bool has_errors(const std::vector<MonitoredCurl>& curls) {
  return std::ranges::any_of(curls, [](const auto& curl) { return curl.error.has_value(); });
}

/// Index of the first step beyond validity; empty: all are valid.
std::optional<std::size_t> first_beyond(const RunToJudge& judged) {
  constexpr double margin_s = 1e-9;  // the same time, read from a text
  const double until_s = judged.valid_until_s.value_or(unbounded) - margin_s;

  const auto& steps = judged.run.steps;
  const auto found = std::ranges::find_if(steps, [&](const v1::StepReport& step) {
    return step.beyond_validity() || step.time_s() >= until_s;
  });
  if (found == steps.end()) return std::nullopt;
  return static_cast<std::size_t>(found - steps.begin());
}

/// The range of curl that the plant wants [m]; a missing end is infinite.
std::optional<v1::Chart::Region> plant_band(const v1::Case& description) {
  const v1::Plausibility& limits = description.plausibility();
  const bool has_least = limits.has_least_curl_m();
  const bool has_greatest = limits.has_greatest_curl_m();
  if (!has_least && !has_greatest) return std::nullopt;

  v1::Chart::Region band;
  band.set_low(has_least ? limits.least_curl_m() : -unbounded);
  band.set_high(has_greatest ? limits.greatest_curl_m() : unbounded);

  const std::string low = fmt::format("{:.4g}", 1e3 * band.low());
  const std::string high = fmt::format("{:.4g}", 1e3 * band.high());
  const std::string range = !has_greatest ? low + " or more"
                            : has_least   ? low + " to " + high
                                          : "up to " + high;
  band.set_name(fmt::format("the plant's band, {} mm", range));
  return band;
}

/// "It is inside the plant's band, 35 to 45 mm.", with a note if the error does not permit this
/// conclusion.
std::string band_sentence(const v1::Chart::Region& band, double curl_m,
                          const case_file::CurlError& error) {
  const auto place_of = [&](double value) {
    return value < band.low() ? "below" : value > band.high() ? "above" : "inside";
  };
  const bool decides =
      std::string(place_of(curl_m - error.lower_m)) == place_of(curl_m + error.upper_m);
  return fmt::format("It is {} {}{}.", place_of(curl_m), band.name(),
                     decides ? "" : ", but its limit is within the error: this run cannot decide");
}

/// A monitor as the subject of a sentence; a mean names its members.
std::string subject(const v1::Case& description, const std::string& name) {
  const auto monitor = std::ranges::find(description.monitor(), name, &v1::Monitor::name);
  if (monitor == description.monitor().end() || monitor->of().empty()) return name;

  std::vector<std::string> members;
  for (const v1::MonitorShare& share : monitor->of()) members.push_back(share.monitor());
  return fmt::format("{}, a mean of {},", name, fmt::join(members, " and "));
}

/// The judged curl at the end: place, value, error, and whether it is within the plant's band.
std::string curl_sentence(const JudgedRun& run, const MonitoredCurl& curl) {
  const v1::StepReport& last = run.steps.back();
  std::string text = fmt::format(
      "At {:.0f} s, after {} mm of casting, {} has {} {} mm since the block started. ",
      last.time_s(), figures::mm(last.cast_length_m(), 0), subject(run.description, curl.monitor),
      curl.end_m < 0.0 ? "sunk" : "risen", figures::mm(std::abs(curl.end_m), 1));

  text += curl.error ? fmt::format(
                           "Mesh and time steps leave {} mm of it uncertain; thermal data and "
                           "alloy come on top.",
                           figures::mm_errors(curl.error->lower_m, curl.error->upper_m, 1))
                     : "Its error from mesh and time steps has not been measured: dccast "
                       "convergence does that.";

  if (const auto band = plant_band(run.description))
    text += " " + band_sentence(*band, curl.end_m, curl.error.value_or(case_file::CurlError{}));
  return text;
}

/// What is left of a curl once the slab has cooled down and lies off its block. Empty: not known.
std::string off_block_sentence(const v1::StepReport& last) {
  if (last.saw_off_m() <= 0.0) return {};
  return fmt::format(
      "Cold and off the block, without its weight, that curl is {} mm above the plane that the "
      "butt "
      "rests on; the butt rises from it by up to {} mm, which are to be sawn off.",
      figures::mm(last.off_block_curl_m(), 1), figures::mm(last.saw_off_m(), 1));
}

/// The last step at which a curl is below this share of its final value.
std::size_t last_below(const MonitoredCurl& curl, double share) {
  std::size_t last = 0;
  for (std::size_t i = 0; i < curl.curl_m.size(); ++i)
    if (curl.curl_m[i] / curl.end_m < share) last = i;
  return last;
}

/// Heat that left through faces and bottom [J, or J/m].
struct Heat {
  double faces = 0.0;
  double bottom = 0.0;
};
Heat heat_of(std::span<const v1::StepReport> steps) {
  Heat heat;
  for (const v1::StepReport& step : steps) {
    const v1::SectionFigures& flow = step.section();
    heat.faces += step.time_step_s() * (flow.side_heat() + flow.narrow_heat());
    heat.bottom += step.time_step_s() * flow.bottom_heat();
  }
  return heat;
}

/// "40 to 98 %", or "98 %".
std::string range_of_percent(double first, double last) {
  const std::string begin = fmt::format("{:.0f}", 100.0 * first);
  const std::string end = fmt::format("{:.0f}", 100.0 * last);
  return begin == end ? end + " %" : fmt::format("{} to {} %", begin, end);
}

/// When half of the judged curl came, and through which faces the heat left meanwhile.
std::string cause_sentence(const JudgedRun& run, const MonitoredCurl& curl) {
  const std::size_t first = last_below(curl, 0.25);
  const std::size_t last = last_below(curl, 0.75);
  const v1::StepReport& begin = run.steps[first];
  const v1::StepReport& end = run.steps[last];
  std::string text = fmt::format(
      "Half of it came between {:.0f} s and {:.0f} s, at {} to {} mm of casting.", begin.time_s(),
      end.time_s(), figures::mm(begin.cast_length_m(), 0), figures::mm(end.cast_length_m(), 0));

  const Heat heat = heat_of(std::span(run.steps).subspan(first + 1, last - first));
  if (heat.faces > 0.0 && heat.bottom > 0.0) {
    const double percent_per_heat = 100.0 / (heat.faces + heat.bottom);
    text += fmt::format(
        " Meanwhile {:.0f} % of the heat left through the faces, to mould and water, "
        "and {:.0f} % through the bottom, to the block.",
        percent_per_heat * heat.faces, percent_per_heat * heat.bottom);
  }

  if (run.description.cooling().water().enabled() && end.wetted_share() > 0.0)
    text += fmt::format(" Water wetted {} of the side under the water line.",
                        range_of_percent(begin.wetted_share(), end.wetted_share()));
  return text;
}

/// The limits that are extrapolated, or those that are the finest run: a column of the table of
/// curls.
void add_limit_column(const std::vector<MonitoredCurl>& curls, bool is_extrapolated,
                      v1::Table& table) {
  const auto belongs = [&](const MonitoredCurl& curl) {
    return curl.limit && curl.limit->is_extrapolated == is_extrapolated;
  };
  if (std::ranges::none_of(curls, belongs)) return;

  v1::Table::Column& column = *table.add_columns();
  column = is_extrapolated ? number_column("limit", "limit", "m", curl_resolution_m)
                           : number_column("finest_mesh", "finest mesh", "m", curl_resolution_m);
  column.set_has_error(true);
  for (std::size_t i = 0; i < curls.size(); ++i)
    *table.mutable_rows(static_cast<int>(i))->add_cells() =
        belongs(curls[i])
            ? number_cell(curls[i].limit->curl_m, std::optional(curls[i].limit->uncertainty_m))
            : v1::Cell();
}

/// The curls at the end with their errors, and what finer meshes tend to.
void add_curl_table(const std::vector<MonitoredCurl>& curls, v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, "curls", "curls at the end");
  add_columns(table, {text_column("monitor", "monitor"),
                      number_column("curl", "curl", "m", curl_resolution_m)});
  table.mutable_columns(1)->set_has_error(has_errors(curls));

  for (const MonitoredCurl& curl : curls)
    add_row(table, {text_cell(curl.monitor), curl_cell(curl.end_m, curl.error)});
  for (const bool is_extrapolated : {true, false}) add_limit_column(curls, is_extrapolated, table);
}

/// The other figures of the last step.
void add_end(const JudgedRun& run, bool is_beyond, v1::Judgement& judgement) {
  const v1::StepReport& last = run.steps.back();
  v1::Table& table = add_table(judgement, "end", "the last step");
  add_columns(table, {
                         number_column("time", "time", "s", 0.1),
                         number_column("cast_length", "cast length", "m", 1e-4),
                         is_quarter(run)
                             ? number_column("contact_area", "stands on the block", "m2", 1e-4)
                             : number_column("contact_length", "stands on the block", "m", 1e-3),
                         number_column("sump_depth", "sump depth", "m", 1e-3),
                     });

  const double contact = is_quarter(run) ? last.contact_area_m2() : last.contact_length_m();
  add_row(table, {number_cell(last.time_s()), number_cell(last.cast_length_m()),
                  number_cell(contact), number_cell(last.sump_depth_m())});
  if (is_beyond) table.set_note("Figures of the last step are beyond validity.");
}

/// Whether the curls are drawn with their own errors; the limits of a study have theirs.
bool has_own_bands(const RunToJudge& judged) {
  return judged.refinement.limits().empty();
}

/// The errors that the quality of the case leaves, around a curl. Without them there is no band.
void add_reported_band(const JudgedRun& run, const std::string& monitor, v1::Chart::Line& line) {
  if (!reported_error(run.steps.back(), monitor)) return;

  for (int i = 0; i < line.y_size(); ++i) {
    const auto error = reported_error(run.steps[static_cast<std::size_t>(i)], monitor)
                           .value_or(case_file::CurlError{});
    line.add_low(line.y(i) - error.lower_m);
    line.add_high(line.y(i) + error.upper_m);
  }
}

void add_limits(const v1::StudyResult& study, bool by_length, v1::Chart& chart) {
  for (const v1::StudyResult::Limit& limit : study.limits()) {
    const v1::CurlCurve& curve = limit.curve();
    const auto& places = by_length ? curve.cast_length_m() : curve.time_s();
    v1::Chart::Line& line =
        add_line(chart, curve.monitor() + ", limit of finer meshes", {places.begin(), places.end()},
                 {curve.curl_m().begin(), curve.curl_m().end()});
    for (int i = 0; i < curve.curl_m_size(); ++i) {
      line.add_low(curve.curl_m(i) - curve.uncertainty_m(i));
      line.add_high(curve.curl_m(i) + curve.uncertainty_m(i));
    }
  }
}

/// What a chart of the curls shows, and what its shaded areas are.
std::string note_on_curls(const RunToJudge& judged, const std::vector<MonitoredCurl>& curls,
                          bool by_length) {
  const std::string beyond = first_beyond(judged) ? " Shaded red: beyond validity." : "";
  if (by_length) return "Against the travel of the bottom block." + beyond;

  const std::string band = !has_own_bands(judged) ? " Shaded: the uncertainty of the limit."
                           : has_errors(curls)
                               ? " Shaded: what mesh and time steps leave uncertain."
                               : "";
  return "Upward displacement of each monitor; time zero is when the bottom block starts." + band +
         beyond;
}

/// The curls against time or cast length, with the plant's band.
void add_curls(const RunToJudge& judged, const std::vector<MonitoredCurl>& curls, bool by_length,
               v1::Judgement& judgement) {
  const JudgedRun& run = judged.run;
  const std::vector<double> places = by_length ? run.cast_length_m() : run.time_s();
  v1::Chart& chart =
      by_length ? add_chart(judgement, "curl_by_length", "curl against cast length",
                            {"cast length", "m", "curl", "m"})
                : add_chart(judgement, "curl", "curl against time", {"time", "s", "curl", "m"});

  for (const MonitoredCurl& curl : curls) {
    v1::Chart::Line& line = add_line(chart, curl.monitor, places, curl.curl_m);
    if (has_own_bands(judged)) add_reported_band(run, curl.monitor, line);
  }
  add_limits(judged.refinement, by_length, chart);

  if (const auto first = first_beyond(judged)) chart.set_beyond_x(places[*first]);
  if (const auto band = plant_band(run.description)) *chart.mutable_region() = *band;
  chart.set_note(note_on_curls(judged, curls, by_length));
}

/// Why a run has no curl at its end; empty: it has one.
std::string without_curl(const RunToJudge& judged) {
  const auto beyond = first_beyond(judged);
  if (!beyond && !judged.run.failed) return {};
  const v1::StepReport& step = beyond ? judged.run.steps[*beyond] : judged.run.steps.back();
  return fmt::format("The run has no curl: it {} {:.0f} s{}, after {} mm of casting.",
                     beyond ? "is not valid from" : "failed at", step.time_s(), beyond ? " on" : "",
                     figures::mm(step.cast_length_m(), 0));
}

constexpr const char* explanation =
    "The same casting with cells and time steps divided by the refinement; curl at the end. The "
    "order is that of the whole history. The limit is extrapolated from the last three runs, with "
    "not more than first order, that of the time steps; its uncertainty is 1.25 times the distance "
    "that is left. Where runs are fewer or do not settle, the limit is the finest run and the "
    "uncertainty 1.25 times the largest difference so far. The ± beside a curl of this run is its "
    "distance to the limit and the limit's uncertainty together. Only discretisation: not the "
    "thermal data, not the material.";

/// Where the errors of the curls come from, or how they can be known.
std::string source_of_errors(const RunToJudge& judged, const std::vector<MonitoredCurl>& curls) {
  const v1::StudyResult& study = judged.refinement;
  if (!study.limits().empty())
    return fmt::format("This run has refinement {}.",
                       std::max(1, judged.run.description.mesh().refinement()));
  if (has_errors(curls))
    return "The ± beside a curl is the band of the case's quality (docs/error-bars.md). dccast "
           "convergence CASE shows it for this case.";
  if (study.runs().empty())
    return "Not known: this run stands alone. dccast convergence CASE shows it.";

  const auto succeeded = std::ranges::count(study.runs(), v1::SUCCEEDED, &v1::StudyRun::state);
  return fmt::format(
      "Not known: of the runs of its study {} succeeded, two are needed. dccast "
      "convergence --study {} shows it.",
      succeeded, study.study().id());
}

/// How much of the curls is discretisation: with a refinement study its sentences and its tables.
void add_discretisation(const RunToJudge& judged, const std::vector<MonitoredCurl>& curls,
                        v1::Judgement& judgement) {
  constexpr auto place = v1::JudgementPart::PAGE;
  std::string note = source_of_errors(judged, curls);
  v1::Table& table =
      add_table(judgement, "discretisation", "how much of it is discretisation", place);
  table.set_note(note);
  if (judged.refinement.limits().empty()) return;

  const v1::Judgement study = judge_study({judged.refinement});
  for (const std::string& sentence : study.sentences()) note += " " + sentence;
  table.set_note(note);

  // Its charts are left out: those of this run have the limits.
  for (const v1::JudgementPart& part : study.parts()) {
    if (!part.has_table()) continue;
    v1::JudgementPart& added = *judgement.add_parts();
    added = part;
    added.set_place(place);
  }

  v1::Table& limits = *judgement.mutable_parts()->rbegin()->mutable_table();
  limits.set_note(limits.note().empty() ? explanation
                                        : fmt::format("{} {}", limits.note(), explanation));
}

}  // namespace

v1::Judgement judge_run(const RunToJudge& judged) {
  constexpr double nothing_m = 1e-4;
  const JudgedRun& run = judged.run;
  const std::vector<MonitoredCurl> curls = monitored_curls(judged);
  const bool is_beyond = first_beyond(judged).has_value();

  v1::Judgement judgement;
  judgement.set_heading(run.name);
  const MonitoredCurl* const judged_curl = find_judged(run, curls);
  const std::string no_curl = without_curl(judged);
  if (!no_curl.empty()) {
    judgement.add_sentences(no_curl);
  } else if (judged_curl != nullptr) {
    judgement.add_sentences(curl_sentence(run, *judged_curl));
    if (std::abs(judged_curl->end_m) >= nothing_m)
      judgement.add_sentences(cause_sentence(run, *judged_curl));
    const std::string settling = settling_sentence(run, judged_curl->curl_m);
    if (!settling.empty()) judgement.add_sentences(settling);
    const std::string off_block = off_block_sentence(run.steps.back());
    if (!off_block.empty()) judgement.add_sentences(off_block);
  }

  if (!curls.empty() && no_curl.empty()) add_curl_table(curls, judgement);
  add_end(run, is_beyond, judgement);
  if (!curls.empty()) {
    for (const bool by_length : {false, true}) add_curls(judged, curls, by_length, judgement);
  }
  if (judged.followed) add_followed(*judged.followed, run, judgement);
  if (run.steps.size() >= 2) add_histories(run, judgement);
  if (!curls.empty()) add_discretisation(judged, curls, judgement);
  if (judged.last_frame) {
    const double until_s = judged.valid_until_s.value_or(unbounded);
    add_frame(run.description, *judged.last_frame, judged.last_frame->time_s() >= until_s,
              judgement);
  }

  // A casting that was followed had other levers than its case.
  add_recipe(run.description, judged.followed ? "plan" : "recipe", judgement);
  add_checks(run, is_beyond, judgement);
  add_basis(run.description, judgement);
  limit_points(judgement, most_points);
  return judgement;
}

}  // namespace dccast::judging
