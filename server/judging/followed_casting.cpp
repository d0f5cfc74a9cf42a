#include "server/judging/followed_casting.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/judging/judgement.hpp"

namespace dccast::judging {
namespace {

constexpr double far_s = 60.0;  ///< of the chart

/// The forecast of a gauge 60 s ahead; an empty one where there is none.
PastForecast find_past(const FollowedCasting& followed, const std::string& monitor) {
  const auto found = std::ranges::find_if(followed.past, [&](const PastForecast& past) {
    return past.monitor == monitor && past.ahead_s == far_s;
  });
  return found == followed.past.end() ? PastForecast{} : *found;
}

/// Root mean square of measured minus expected [m]; NaN without a reading.
double error_m(const PastForecast& past) {
  double sum = 0.0;
  for (std::size_t i = 0; i < past.time_s.size(); ++i)
    sum += std::pow(past.measured_m[i] - past.expected_m[i], 2);
  return std::sqrt(sum / static_cast<double>(past.time_s.size()));
}

/// Share of the readings inside the band; NaN without a reading.
double inside_band(const PastForecast& past) {
  double inside = 0.0;
  for (std::size_t i = 0; i < past.time_s.size(); ++i)
    if (past.measured_m[i] >= past.lower_m[i] && past.measured_m[i] <= past.upper_m[i]) ++inside;
  return inside / static_cast<double>(past.time_s.size());
}

void add_forecast_chart(const v1::ForecastCurl& gauge, const PastForecast& past,
                        const JudgedRun& run, v1::Judgement& judgement) {
  v1::Chart& chart =
      add_chart(judgement, "forecast", fmt::format("{}, measured and forecast", gauge.monitor()),
                {"time", "s", "curl", "m"});
  add_line(chart, "measured", {gauge.measured_time_s().begin(), gauge.measured_time_s().end()},
           {gauge.measured_m().begin(), gauge.measured_m().end()})
      .set_is_dotted(true);
  if (const auto computed = run.curl_m(gauge.monitor()); !computed.empty())
    add_line(chart, "computed", run.time_s(), computed);
  v1::Chart::Line& forecast =
      add_line(chart, fmt::format("forecast {:.0f} s before", far_s), past.time_s, past.expected_m);
  forecast.mutable_low()->Add(past.lower_m.begin(), past.lower_m.end());
  forecast.mutable_high()->Add(past.upper_m.begin(), past.upper_m.end());

  chart.set_note(
      fmt::format("Forecast: what the gauge was expected to show, as of {:.0f} s before each time, "
                  "with the band "
                  "of nine in ten. Computed: the run with the measured levers.",
                  far_s));
}

void add_forecast_table(const FollowedCasting& followed, v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, "forecast", "forecast against measured curl");
  add_columns(table, {
                         text_column("gauge", "gauge"),
                         number_column("ahead", "ahead", "s", 1.0),
                         number_column("forecasts", "forecasts", "", 1.0),
                         number_column("error", "error", "m", 1e-5),
                         number_column("inside", "in band", "1", 0.01),
                     });
  for (const PastForecast& past : followed.past)
    add_row(table, {text_cell(past.monitor), number_cell(past.ahead_s),
                    number_cell(static_cast<double>(past.time_s.size())),
                    number_cell(error_m(past)), number_cell(inside_band(past))});

  std::string note;
  for (const v1::ForecastCurl& gauge : followed.forecast.curls())
    note += fmt::format("{}: {} readings were used and {} left out. ", gauge.monitor(),
                        gauge.readings(), gauge.left_out());
  table.set_note(
      note +
      "The error is the root mean square of reading minus forecast, over forecasts from the start "
      "of the block on. Readings that were left out do not count, nor forecasts from before a slip "
      "of the gauge for times after it." +
      (followed.forecast.warnings().empty() && !followed.has_findings ? " No warning was raised."
                                                                      : ""));
}

void add_warnings(const v1::Forecast& forecast, v1::Judgement& judgement) {
  if (forecast.warnings().empty()) return;
  v1::Table& table =
      add_table(judgement, "warnings", "warnings of the forecast", v1::JudgementPart::PAGE);
  add_columns(table, {
                         number_column("time", "time", "s", 1.0),
                         text_column("gauge", "gauge"),
                         text_column("warning", "warning"),
                         text_column("causes", "likeliest"),
                     });

  for (const v1::ForecastWarning& warning : forecast.warnings())
    add_row(table, {number_cell(warning.time_s()), text_cell(warning.monitor()),
                    text_cell(warning.text()), text_cell(joined(warning.causes(), ", "))});
}

void add_poured(const FollowedCasting& followed, v1::Judgement& judgement) {
  if (followed.poured.empty()) return;
  v1::Table& table = add_table(judgement, "poured", "what was cast, beside the plan");
  for (const auto& [key, heading] : {std::pair{"lever", "lever"},
                                     {"measured", "measured, mean"},
                                     {"range", "least to most"},
                                     {"planned", "planned, mean"}})
    add_columns(table, {text_column(key, heading)});
  for (const levers::PouredLever& lever : followed.poured)
    add_row(table, {text_cell(lever.name), text_cell(lever.measured), text_cell(lever.range),
                    text_cell(lever.planned)});
  table.set_note("Readings from 10 s on. The run was computed with these.");
}

}  // namespace

void add_followed(const FollowedCasting& followed, const JudgedRun& run, v1::Judgement& judgement) {
  add_poured(followed, judgement);
  if (!followed.no_forecast.empty()) {
    add_table(judgement, "forecast", "forecast against measured curl")
        .set_note("No forecast: " + followed.no_forecast + ".");
    return;
  }

  for (const v1::ForecastCurl& gauge : followed.forecast.curls())
    add_forecast_chart(gauge, find_past(followed, gauge.monitor()), run, judgement);
  add_forecast_table(followed, judgement);
  add_warnings(followed.forecast, judgement);
}

}  // namespace dccast::judging
