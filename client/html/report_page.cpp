#include "client/html/report_page.hpp"

#include "client/html/curl_part.hpp"
#include "client/html/frame_part.hpp"
#include "client/html/history_part.hpp"
#include "client/html/html_parts.hpp"
#include "client/html/recipe_part.hpp"
#include "client/html/report_style.hpp"
#include "client/html/run_part.hpp"
#include "client/html/study_part.hpp"
#include "client/html/svg_chart.hpp"
#include "client/model/answer.hpp"
#include "client/model/curl_history.hpp"
#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

/// The sentence at the top of a page with figures beyond validity.
std::string validity_banner(const v1::Job& job, const CurlHistory& history) {
  const auto first = history.first_beyond();
  if (!first && !job.has_validity_loss()) return {};
  const std::string loss = job.has_validity_loss() ? validity_text(job.validity_loss())
                                                   : std::string(beyond_validity) + " from " +
                                                         fixed(history.time_s[*first], 2) + " s on";
  return "<p class='invalid'>This run is " + html_escaped(loss) +
         ". Figures after that time are marked; they are not valid.</p>";
}

std::string page_header(const v1::Job& job, const std::string& title) {
  return "<header><p class='kicker'>dccast report · job " + html_escaped(job.id().substr(0, 8)) +
         " · <span class='state " + state_text(job.state()) + "'>" + state_text(job.state()) +
         "</span></p>" + element("h1", title) + "</header>";
}

/// The part for the plant, on one sheet of paper.
std::string first_sheet(const v1::Job& job, const v1::QueryResultResponse& result,
                        const CurlHistory& history, const Study& study, const FrameSeries& series) {
  return findings_part(job.findings()) + validity_banner(job, history) +
         curl_sentence(history, result, study) + headline(history, result, study) +
         "<div class='cards'>" + curl_figures(history, result, study) + recipe_part(result) +
         history_part(result) + frame_part(result, history, series) + "</div>";
}

/// What is known of the discretisation: of the study, else of the quality that the case follows.
std::string discretisation_part(const v1::Job& job, const v1::QueryResultResponse& result,
                                const Study& study) {
  if (study.monitors.empty() && discretisation_error(result.case_(), 1.0))
    return "<p class='note'>The ± beside a curl is the band of the case's quality "
           "(docs/error-bars.md). <code>dccast convergence CASE</code> shows it for this case.</p>";
  return study_part(study, job);
}

/// The evidence behind the figures.
std::string second_sheet(const v1::Job& job, const v1::QueryResultResponse& result,
                         const CurlHistory& history, const Study& study) {
  const std::string of_the_study =
      history.monitors.empty() ? "" : discretisation_part(job, result, study);
  return "<div class='sheet'>" + of_the_study + "<div class='cards'>" +
         run_part(job, result, history) + "</div></div>";
}

}  // namespace

std::string report_page(const v1::Job& job, const v1::QueryResultResponse& result,
                        const Study& study, const FrameSeries& series) {
  const CurlHistory history = curl_history(job, result);
  const std::string title = html_escaped(job.title().empty() ? "Casting " + job.id() : job.title());
  const std::string body = page_header(job, title) +
                           first_sheet(job, result, history, study, series) +
                           second_sheet(job, result, history, study);
  return "<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
         "content='width=device-width, initial-scale=1'><title>" +
         title + "</title><style>" + report_style + "</style></head><body><main>" + body +
         "</main></body></html>\n";
}

}  // namespace dccast::client::render
