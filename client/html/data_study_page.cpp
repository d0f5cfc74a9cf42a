#include <fmt/core.h>

#include "client/html/html_parts.hpp"
#include "client/html/pages.hpp"
#include "client/session/data_study.hpp"
#include "client/text/data_study_text.hpp"
#include "client/text/study_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

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

}  // namespace

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

}  // namespace dccast::client::render
