#include <algorithm>
#include <cmath>

#include <fmt/core.h>

#include "client/html/html_parts.hpp"
#include "client/html/pages.hpp"
#include "client/session/data_study.hpp"
#include "client/text/data_study_text.hpp"
#include "client/text/study_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

constexpr int most_lines = 6;  // that the style has colours for

std::string page(const v1::StudyResult& result, const std::string& body) {
  return study_page(result.study(), "Study",
                    std::to_string(result.runs_size()) + " runs: " + count_runs(result).text(),
                    body);
}

std::vector<double> scaled(const google::protobuf::RepeatedField<double>& values, double factor) {
  std::vector<double> all(values.begin(), values.end());
  for (double& value : all) value *= factor;
  return all;
}

std::string curl_chart(const v1::Spread& spread, std::optional<double> mesh_error) {
  Chart chart{"Curl of the " + spread.monitor() + " against time", "time, s", "curl, mm", {}};
  const std::vector<double> time_s = scaled(spread.time_s(), 1.0),
                            median = scaled(spread.median_m(), 1e3);
  chart.lines.push_back(
      {"data, 5 to 95 %",
       {},
       {},
       {time_s, median, scaled(spread.low_m(), 1e3), scaled(spread.high_m(), 1e3)}});
  if (mesh_error)
    chart.lines.push_back(
        {"mesh and time steps", {}, {}, band_around({"", time_s, median}, *mesh_error)});
  return svg_chart(chart);
}

std::string shares_chart(const v1::StudyResult& result) {
  const v1::Spread& spread = result.spread();
  std::vector<int> axes;
  for (int axis = 0; axis + 1 < spread.shares_size(); ++axis) axes.push_back(axis);
  const auto most = [&](int axis) {
    const auto& total = spread.shares(axis).total();
    return total.empty() ? 0.0 : *std::ranges::max_element(total);
  };
  std::ranges::stable_sort(axes, std::ranges::greater(), most);
  Chart chart{"Share of each datum in the variance, with interactions", "time, s", "share, %", {}};
  for (const int axis : axes) {
    if (chart.lines.size() == most_lines) break;
    chart.lines.push_back({datum_of(result.study().sweep().axes(axis).key()),
                           scaled(spread.index_time_s(), 1.0),
                           scaled(spread.shares(axis).total(), 100.0)});
  }
  return svg_chart(chart);
}

Chart measured_chart(const v1::Calibration& calibration, const v1::Calibration::Curve& curve) {
  const double units = shown_units(curve);
  const std::vector<double> time_s = scaled(curve.time_s(), 1.0);
  const auto band = [&](const v1::Calibration::Band& of) {
    return ChartBand{time_s, scaled(of.median(), units), scaled(of.low(), units),
                     scaled(of.high(), units)};
  };
  const auto& measured = curve.measured();
  const bool curl = measured.curl_m_size() > 0;
  Chart chart{curve_name(calibration, curve) + " against time",
              "time, s",
              curl ? "curl, mm" : "temperature, °C",
              {}};
  chart.lines = {{"measured",
                  scaled(measured.time_s(), 1.0),
                  scaled(curl ? measured.curl_m() : measured.temperature_c(), units),
                  {},
                  true},
                 {"data before, 5 to 95 %", {}, {}, band(curve.before())},
                 {"data after, 5 to 95 %", {}, {}, band(curve.after())}};
  if (curl && calibration.has_mesh_error())
    chart.lines.push_back(
        {"mesh and time steps",
         {},
         {},
         band_around({"", time_s, scaled(curve.best(), units)}, calibration.mesh_error())});
  return chart;
}

/// Runs that the figures do not rest on, each with its values.
std::string lost_runs(const v1::StudyResult& result) {
  std::string rows;
  for (int i = 0; i < result.runs_size(); ++i) {
    const v1::StudyRun& run = result.runs(i);
    if (run.state() == v1::SUCCEEDED && !run.beyond_validity()) continue;
    std::string text = fmt::format(
        "Run {}: {}", i + 1,
        html_escaped(run_text(run) + (run.has_failure() ? ": " + run.failure().message() : "")));
    text += "<br><code>";
    for (int axis = 0; axis < run.values_size(); ++axis)
      if (!run.values(axis).empty())
        text +=
            html_escaped(result.study().sweep().axes(axis).key() + " = " + run.values(axis)) + "; ";
    rows += element("p", text + "</code>");
  }
  return rows.empty() ? "" : card("Runs that the figures do not rest on", rows);
}

/// Horizontal bars about the case itself.
std::string bars(const v1::StudyResult& result, const Effects& effects) {
  constexpr double row = 22.0, middle = 680.0, half = 190.0;
  const double most = effects.effects.empty() ? 0.0 : effects.effects.front().largest_m();
  if (!(most > 0.0)) return {};
  const double height = row * static_cast<double>(effects.effects.size()) + 30.0;
  const double error = half * std::min(1.0, effects.error_m.value_or(0.0) / most);
  std::string svg = fmt::format(
      "<svg viewBox='0 0 910 {:.0f}' role='img' aria-label='effect of each key on the curl'>"
      "<rect class='wanted' x='{:.1f}' y='4' width='{:.1f}' height='{:.1f}'/>",
      height, middle - error, 2.0 * error, height - 26.0);
  double top = 8.0;
  for (const Effect& effect : effects.effects) {
    const auto& axis = result.study().sweep().axes(effect.axis);
    svg += fmt::format("<text class='label' text-anchor='end' x='470' y='{:.1f}'>{}</text>",
                       top + 12.0, html_escaped(axis.key() + ", " + range_of(axis)));
    const auto bar = [&](const std::optional<double>& amount, double y, int colour) {
      if (!amount) return;
      const double length = half * std::abs(*amount) / most;
      svg += fmt::format(
          "<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='7' style='fill:var(--line-{})'>"
          "<title>{:.2f} mm</title></rect>",
          *amount < 0.0 ? middle - length : middle, y, length, colour, 1e3 * *amount);
    };
    bar(effect.low_m, top + 1.0, 0);
    bar(effect.high_m, top + 9.0, 1);
    top += row;
  }
  svg += fmt::format("<line class='zero' x1='{0:.0f}' x2='{0:.0f}' y1='4' y2='{1:.1f}'/>", middle,
                     height - 22.0);
  for (const double side : {-1.0, 1.0})
    svg += fmt::format(
        "<text class='tick' text-anchor='middle' x='{:.0f}' y='{:.1f}'>{:.1f} mm</text>",
        middle + side * half, height - 6.0, 1e3 * side * most);
  return svg + "</svg>";
}

}  // namespace

std::string uncertainty_page(const v1::StudyResult& result, std::optional<double> mesh_error) {
  const v1::Spread& spread = result.spread();
  std::string body = answer(uncertainty_sentences(result, mesh_error));
  if (!spread.median_m().empty()) {
    body += "<div class='pair'>" +
            card("What the data leave open of the " + html_escaped(spread.monitor()),
                 curl_chart(spread, mesh_error)) +
            card("Where it comes from", shares_chart(result)) + "</div>";
    body += card("Shares of the variance at the end",
                 table_of({"datum", "range", "alone", "with others"}, share_rows(result)) +
                     "<p>Sobol's indices of the response surface, with twice the error of their "
                     "sampling. docs/uncertainty.md.</p>");
  }
  return page(result, body + lost_runs(result));
}

std::string calibration_page(const v1::StudyResult& result) {
  const v1::Calibration& calibration = result.calibration();
  std::string body = answer(calibration_sentences(result));
  if (!result.has_calibration()) return page(result, body + lost_runs(result));
  for (const auto& curve : calibration.curves())
    body += card(html_escaped(curve_name(calibration, curve)) + ", measured and computed",
                 svg_chart(measured_chart(calibration, curve)));
  body += card("The data after the measurement",
               table_of({"free key", "range before", "value", "5 to 95 % after", "width left"},
                        key_rows(result)));
  body += card("How the model follows what was measured",
               table_of({"measured", "in", "readings used", "off before", "after", "noise",
                         "misfit", "surface"},
                        curve_rows(calibration)) +
                   "<p>Root mean squares and standard deviations. docs/calibration.md.</p>");
  return page(result, body + lost_runs(result));
}

std::string sensitivity_page(const v1::StudyResult& result, int monitor,
                             std::optional<double> of_curl) {
  const Effects effects = effects_of(result, monitor, of_curl);
  if (!effects.base_m)
    return page(result,
                card("Nothing to compare with", "<p>The case itself has no valid run.</p>") +
                    lost_runs(result));
  const EffectRows rows = effect_rows(result, effects);
  std::string body =
      card("Change of the curl of the " + html_escaped(result.monitors(monitor)) + " at the end, " +
               mm(*effects.base_m) + " mm in the case itself",
           bars(result, effects) + "<p>Blue: lower end of the range, orange: upper end. " +
               (effects.error_m
                    ? "Shaded: what mesh and time steps leave uncertain of a difference, ± " +
                          mm(*effects.error_m) + " mm.</p>"
                    : "The error of a difference has not been measured for such a case.</p>"));
  if (!rows.rest.empty())
    body += "<p class='note'>This model does not respond to " + html_escaped(rows.rest) + ".</p>";
  return page(result, body + lost_runs(result));
}

}  // namespace dccast::client::render
