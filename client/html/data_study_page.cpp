#include "client/html/data_study_page.hpp"

#include <algorithm>
#include <cmath>

#include "client/html/html_parts.hpp"
#include "client/html/study_page.hpp"
#include "client/html/svg_chart.hpp"
#include "client/model/effects.hpp"
#include "client/session/data_study.hpp"
#include "client/text/calibration_text.hpp"
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

/// What the data leave open, and what mesh and time steps add to the median.
struct CurlBands {
  ChartBand data, mesh;
};

CurlBands bands_of(const v1::Spread& spread, double mesh_error) {
  CurlBands bands;
  for (int i = 0; i < spread.time_s_size(); ++i) {
    const double middle = 1e3 * spread.median_m(i);
    for (ChartBand* band : {&bands.data, &bands.mesh}) {
      band->x.push_back(spread.time_s(i));
      band->middle.push_back(middle);
    }
    bands.data.low.push_back(1e3 * spread.low_m(i));
    bands.data.high.push_back(1e3 * spread.high_m(i));
    bands.mesh.low.push_back(middle - mesh_error * std::abs(middle));
    bands.mesh.high.push_back(middle + mesh_error * std::abs(middle));
  }
  return bands;
}

std::string curl_chart(const v1::Spread& spread, std::optional<double> mesh_error) {
  Chart chart{"Curl of the " + spread.monitor() + " against time", "time, s", "curl, mm", {}};
  CurlBands bands = bands_of(spread, mesh_error.value_or(0.0));
  chart.lines.push_back({"data, 5 to 95 %", {}, {}, std::move(bands.data)});
  if (mesh_error) chart.lines.push_back({"mesh and time steps", {}, {}, std::move(bands.mesh)});
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
    ChartLine& line = chart.lines.emplace_back();
    line.name = datum_of(result.study().sweep().axes(axis).key());
    for (int i = 0; i < spread.index_time_s_size(); ++i) {
      line.x.push_back(spread.index_time_s(i));
      line.y.push_back(100.0 * spread.shares(axis).total(i));
    }
  }
  return svg_chart(chart);
}

Chart measured_chart(const v1::Calibration& calibration, const v1::Calibration::Curve& curve) {
  const double units = shown_units(curve);
  const auto scaled = [&](const google::protobuf::RepeatedField<double>& values) {
    std::vector<double> shown(values.begin(), values.end());
    for (double& value : shown) value *= units;
    return shown;
  };
  const std::vector<double> time_s(curve.time_s().begin(), curve.time_s().end());
  const auto band = [&](const v1::Calibration::Band& of) {
    return ChartBand{time_s, scaled(of.median()), scaled(of.low()), scaled(of.high())};
  };
  const auto& measured = curve.measured();
  const bool curl = measured.curl_m_size() > 0;
  Chart chart{curve_name(calibration, curve) + " against time",
              "time, s",
              curl ? "curl, mm" : "temperature, °C",
              {}};
  chart.lines.push_back({"measured",
                         {measured.time_s().begin(), measured.time_s().end()},
                         scaled(curl ? measured.curl_m() : measured.temperature_c())});
  chart.lines.push_back({"data before, 5 to 95 %", {}, {}, band(curve.before())});
  chart.lines.push_back({"data after, 5 to 95 %", {}, {}, band(curve.after())});
  if (!curl || !calibration.has_mesh_error()) return chart;
  ChartBand mesh{time_s, scaled(curve.best()), {}, {}};
  for (const double value : mesh.middle) {
    mesh.low.push_back(value - calibration.mesh_error() * std::abs(value));
    mesh.high.push_back(value + calibration.mesh_error() * std::abs(value));
  }
  chart.lines.push_back({"mesh and time steps", {}, {}, mesh});
  return chart;
}

/// Runs that the figures do not rest on, each with its values.
std::string lost_runs(const v1::StudyResult& result) {
  std::string rows;
  for (int i = 0; i < result.runs_size(); ++i) {
    const v1::StudyRun& run = result.runs(i);
    if (run.state() == v1::SUCCEEDED && !run.beyond_validity()) continue;
    rows += "<p>Run " + std::to_string(i + 1) + ": " + html_escaped(run_text(run));
    if (run.has_failure()) rows += ": " + html_escaped(run.failure().message());
    rows += "<br><code>";
    for (int axis = 0; axis < run.values_size(); ++axis)
      if (!run.values(axis).empty())
        rows +=
            html_escaped(result.study().sweep().axes(axis).key() + " = " + run.values(axis)) + "; ";
    rows += "</code></p>";
  }
  return rows.empty() ? "" : card("Runs that the figures do not rest on", rows);
}

/// Horizontal bars about the case itself.
std::string bars(const v1::StudyResult& result, const Effects& effects) {
  constexpr double row = 22.0, middle = 680.0, half = 190.0;
  const double most = effects.effects.empty() ? 0.0 : effects.effects.front().largest_m();
  if (!(most > 0.0)) return {};
  const double height = row * static_cast<double>(effects.effects.size()) + 30.0;
  std::string svg = "<svg viewBox='0 0 910 " + fixed(height, 0) +
                    "' role='img' aria-label='effect of each key on the curl'>";
  const double error = half * std::min(1.0, effects.error_m.value_or(0.0) / most);
  svg += "<rect class='wanted' x='" + fixed(middle - error, 1) + "' y='4' width='" +
         fixed(2.0 * error, 1) + "' height='" + fixed(height - 26.0, 1) + "'/>";
  double top = 8.0;
  for (const Effect& effect : effects.effects) {
    const auto& axis = result.study().sweep().axes(effect.axis);
    svg += "<text class='label' text-anchor='end' x='470' y='" + fixed(top + 12.0, 1) + "'>" +
           html_escaped(axis.key() + ", " + range_of(axis)) + "</text>";
    for (const auto& [amount, colour] :
         {std::pair(effect.low_m, "var(--line-0)"), std::pair(effect.high_m, "var(--line-1)")}) {
      if (!amount) continue;
      const double length = half * std::abs(*amount) / most;
      svg += "<rect x='" + fixed(*amount < 0.0 ? middle - length : middle, 1) + "' y='" +
             fixed(top + (colour[11] == '0' ? 1.0 : 9.0), 1) + "' width='" + fixed(length, 1) +
             "' height='7' style='fill:" + colour + "'><title>" + fixed(1e3 * *amount, 2) +
             " mm</title></rect>";
    }
    top += row;
  }
  svg += "<line class='zero' x1='" + fixed(middle, 0) + "' x2='" + fixed(middle, 0) +
         "' y1='4' y2='" + fixed(height - 22.0, 1) + "'/>";
  for (const double side : {-1.0, 1.0})
    svg += "<text class='tick' text-anchor='middle' x='" + fixed(middle + side * half, 0) +
           "' y='" + fixed(height - 6.0, 1) + "'>" + fixed(1e3 * side * most, 1) + " mm</text>";
  return svg + "</svg>";
}

}  // namespace

std::string uncertainty_page(const v1::StudyResult& result, std::optional<double> mesh_error) {
  const v1::Spread& spread = result.spread();
  std::string body;
  for (const std::string& sentence : uncertainty_sentences(result, mesh_error))
    body += html_escaped(sentence) + " ";
  body = "<p class='answer'>" + body + "</p>";
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
  std::string body;
  for (const std::string& sentence : calibration_sentences(result))
    body += html_escaped(sentence) + " ";
  body = "<p class='answer'>" + body + "</p>";
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
               fixed(1e3 * *effects.base_m, 1) + " mm in the case itself",
           bars(result, effects) + "<p>Blue: lower end of the range, orange: upper end. " +
               (effects.error_m
                    ? "Shaded: what mesh and time steps leave uncertain of a difference, ± " +
                          fixed(1e3 * *effects.error_m, 1) + " mm.</p>"
                    : "The error of a difference has not been measured for such a case.</p>"));
  if (!rows.rest.empty())
    body += "<p class='note'>This model does not respond to " + html_escaped(rows.rest) + ".</p>";
  return page(result, body + lost_runs(result));
}

}  // namespace dccast::client::render
