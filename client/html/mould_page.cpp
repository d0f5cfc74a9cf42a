#include "client/html/mould_page.hpp"

#include "client/html/report_style.hpp"
#include "client/html/svg_chart.hpp"
#include "client/text/mould_text.hpp"
#include "client/text/study_text.hpp"

namespace dccast::client::render {
namespace {

constexpr std::size_t most_lines = 6;  // that the style has colours for

std::vector<double> in_mm(const std::vector<double>& metres) {
  std::vector<double> scaled;
  for (const double value : metres) scaled.push_back(1e3 * value);
  return scaled;
}

using Along = std::vector<double> frames::SteadyFace::*;

/// One line a run, of as many of the last ones as there are colours for.
std::string chart_of(const MouldDesign& design, const std::string& title, Along along,
                     bool with_tolerance) {
  Chart chart{title, "distance from the middle of the wide face, mm", "half-thickness, mm", {}};
  std::size_t number = 0;
  for (const MouldRun& run : design.runs) {
    ++number;
    if (run.cast)
      chart.lines.push_back({"run " + std::to_string(number), in_mm(run.cast->face.x_m),
                             in_mm(run.cast->face.*along)});
  }
  if (chart.lines.size() > most_lines)
    chart.lines.erase(chart.lines.begin(), chart.lines.end() - most_lines);
  if (chart.lines.empty()) return {};
  const double tolerance = design.result.study().mould().tolerance_m();
  if (with_tolerance)
    chart.wanted = Chart::Wanted{1e3 * (design.wanted_m - tolerance),
                                 1e3 * (design.wanted_m + tolerance), "wanted"};
  return "<section class='card'><figure>" + svg_chart(chart) + "<figcaption><strong>" +
         html_escaped(title) + "</strong></figcaption></figure></section>";
}

std::string table_card(const std::string& title, const std::string& table) {
  if (table.empty()) return {};
  return "<section class='card'><h2>" + title + "</h2><pre>" + html_escaped(table) +
         "</pre></section>";
}

}  // namespace

std::string mould_page(const MouldDesign& design) {
  const v1::Study& study = design.result.study();
  return "<!doctype html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
         "content='width=device-width,initial-scale=1'><title>" +
         html_escaped(study.title()) + "</title><style>" + report_style +
         "</style></head><body><main><header><p class='kicker'>Mould design " +
         html_escaped(study.id()) + "</p><h1>" + html_escaped(study.title()) +
         "</h1><p class='note'>" + html_escaped(mould_sentence(design)) +
         "</p></header><div class='pair'>" +
         chart_of(design, "Half-opening of the mould", &frames::SteadyFace::mould_m, false) +
         chart_of(design, "Cold slab", &frames::SteadyFace::cold_m, true) + "</div>" +
         table_card("Opening", mould_opening_table(design)) +
         table_card("Predicted cold slab", mould_profile_table(design)) +
         table_card("Runs", mould_runs_table(design)) + "</main></body></html>\n";
}

}  // namespace dccast::client::render
