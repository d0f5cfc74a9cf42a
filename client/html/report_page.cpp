#include <algorithm>
#include <array>
#include <optional>
#include <ostream>
#include <string_view>

#include <fmt/core.h>

#include "client/html/frame_bytes.hpp"
#include "client/html/html_parts.hpp"
#include "client/html/judgement_parts.hpp"
#include "client/html/pages.hpp"
#include "client/model/answer.hpp"
#include "client/session/jobs.hpp"
#include "client/session/queries.hpp"
#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/judgement_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/plant_words.hpp"

namespace dccast::client {
namespace {

/// The job behind the run.
std::string run_table(const v1::Job& job) {
  std::string rows = row("State", full_state_text(job)) + row("Job", html_escaped(job.id())) +
                     row("Study", job.study().empty() ? "none" : html_escaped(job.study())) +
                     row("Ended", time_text(job.end_time())) +
                     row("Case SHA-256", element("code", html_escaped(job.case_sha256())));
  if (job.has_last_step()) rows += row("Solver time", duration_text(job.last_step().solver_s()));
  if (job.has_failure()) rows += row("Failure", html_escaped(failure_text(job.failure())));
  return card("Run", element("table class='facts'", rows));
}

/// What the result rests on, with the whole case.
std::string basis_part(const ReportedRun& run) {
  if (!run.result.has_case_()) return {};
  const std::string whole_case =
      "<details><summary>The whole case, with all defaults</summary>" +
      element("pre", html_escaped(case_file::readable_toml(run.result.case_()))) + "</details>";

  const v1::Table& basis = find_table(run.judgement, "basis");
  return basis.rows().empty() ? card("Case", whole_case) : facts_card(basis, whole_case);
}

/// The sentence at the top of the page of a job that failed, unless validity_banner() names the
/// cause.
std::string failure_banner(const v1::Job& job) {
  if (!job.has_failure() || job.has_validity_loss()) return {};
  return element("p class='invalid'",
                 "The run failed: " + html_escaped(failure_text(job.failure())));
}

/// The sentence at the top of a page with figures beyond validity.
std::string validity_banner(const v1::Job& job, const figures::RunHistory& history) {
  const auto from_s = history.beyond_from_s();
  if (!from_s && !job.has_validity_loss()) return {};
  const std::string loss = job.has_validity_loss() ? validity_text(job.validity_loss())
                                                   : std::string(beyond_validity) + " from " +
                                                         fixed(*from_s, 2) + " s on";
  return element("p class='invalid'",
                 "This run is " + html_escaped(loss) +
                     ". Figures after that time are marked; they are not valid.");
}

/// "1 danger, 2 warnings" beside the state.
std::string findings_mark(const v1::Job& job) {
  if (job.findings().empty()) return {};
  const bool danger = std::ranges::any_of(job.findings(), [](const auto& finding) {
    return finding.severity() == v1::Finding::DANGER;
  });
  return std::string(" · <span class='state") + (danger ? " failed" : "") + "'>" +
         findings_count(job.findings()) + "</span>";
}

std::string page_header(const v1::Job& job, const std::string& title) {
  const std::string quality = job.quality().empty() ? "" : " · " + html_escaped(job.quality());
  const bool is_draft = job.quality() == "draft";
  return fmt::format(
      "<p class='kicker'>dccast " DCCAST_VERSION
      " report · job {0}{1} · {2} · <span class='state {3}'>{3}</span>{4}</p><h1>{5}</h1>{6}",
      html_escaped(job.id().substr(0, 8)), quality, time_text(job.end_time()),
      state_text(job.state()), findings_mark(job), title,
      is_draft ? "<p class='draft'>This is a draft: for a first look. Compute it again at "
                 "engineering before you decide.</p>"
               : "");
}

/// What the server concludes: the answer, then its cause.
std::string sentences(const v1::Judgement& judgement) {
  std::string html;
  for (const std::string& sentence : judgement.sentences())
    html += element(html.empty() ? "p class='answer'" : "p class='cause'", html_escaped(sentence));
  return html;
}

/// A box for each number of a table, with its error; the text of its row is part of its name.
std::string boxes(const v1::Table& table) {
  std::string html;
  const std::vector<ShownColumn> columns = shown_columns(table);
  for (std::size_t row = 0; row < static_cast<std::size_t>(table.rows_size()); ++row) {
    std::string row_name;
    for (const ShownColumn& column : columns) {
      if (!column.is_number) row_name = ", " + column.cells[row];
      if (!column.is_number || column.cells[row].empty()) continue;

      const std::string error = column.has_error ? column.errors[row] : "";
      html += fmt::format("<div class='tile'><span>{}</span><strong>{}</strong> {}{}</div>",
                          html_escaped(column.heading + row_name), column.cells[row], column.unit,
                          error.empty()
                              ? ""
                              : fmt::format("<em>{}{} {}</em>", error.starts_with('-') ? "" : "± ",
                                            error, column.unit));
    }
  }
  return html;
}

/// The figures of the last step; before the first one, what is to be cast.
std::string headline(const ReportedRun& run) {
  const v1::Table& end = find_table(run.judgement, "end");
  if (end.rows().empty())
    return "<p>The job has no step yet.</p>" +
           element("p", html_escaped(case_file::casting_summary(run.result.case_())));
  return element("div class='tiles'", boxes(find_table(run.judgement, "curls")) + boxes(end)) +
         (end.note().empty() ? "" : element("p class='note'", html_escaped(end.note())));
}

constexpr const char* chart_of_first_sheet = "curl";

/// The chart of the curl against time.
std::string curl_figure(const v1::Judgement& judgement) {
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.chart().key() == chart_of_first_sheet) return chart_figure(part.chart());
  return {};
}

/// The frames as report.js reads them; empty if the last one cannot be drawn.
std::optional<Json> slab_json(const FrameSeries& series, const figures::RunHistory& history) {
  Json json{{"times", Json::array()},
            {"fields", Json::array()},
            {"frames", Json::array()},
            {"values", Json::object()}};
  for (const v1::Frame& frame : series.frames) {
    const auto bytes = frame_bytes(frame, Precision::drawing);
    const bool is_last = &frame == &series.frames.back();
    if (!bytes && is_last) return std::nullopt;
    if (!bytes) continue;
    json["times"].push_back(frame.time_s());
    json["frames"].push_back(packed(*bytes));
  }

  for (const v1::FrameField& field : series.fields) {
    json["fields"].push_back(to_json(field));
    json["values"][field.name()] = packed(float_bytes(field.values(), Precision::drawing));
  }
  if (const auto from_s = history.beyond_from_s()) json["beyond_s"] = *from_s;
  return json;
}

/// The stored frames, which a script of the page draws. A line reports that there is none.
std::string slab_part(const ReportedRun& run, const figures::RunHistory& history) {
  if (!run.result.has_frame())
    return card("Slab", "<p>No stored frame: the run has not ended with a result.</p>");
  const v1::Frame& frame = run.result.frame();
  const FrameSeries shown = run.series.frames.empty() ? FrameSeries{1, {frame}, {}} : run.series;
  const auto json = slab_json(shown, history);
  if (!json)
    return card("Slab", "<p>The stored frame cannot be drawn: its arrays are inconsistent.</p>");

  const auto from_s = history.beyond_from_s();
  const bool is_valid = !from_s || frame.time_s() < *from_s;
  const auto count = static_cast<int>(shown.frames.size());
  const std::string caption = fmt::format(
      "{}The last frame is at {} s, cast length {} mm; {} stored frames are in this page. Grey "
      "lines: before the metal moved. Thin lines: the values named below the colours.",
      is_valid ? "" : "<strong>Beyond validity.</strong> ", fixed(frame.time_s(), 1),
      mm(frame.cast_length_m()),
      count == shown.stored ? fmt::format("all {}", count)
                            : fmt::format("{} of {}", count, shown.stored));
  return element("section class='card wide slab'",
                 drawn("slab", *json) + element("div class='caption'", caption));
}

/// The part for the plant, printed on one sheet.
std::string first_sheet(const ReportedRun& run, const figures::RunHistory& history) {
  return "<div class='first'>" + failure_banner(run.job) + validity_banner(run.job, history) +
         sentences(run.judgement) + findings_part(run.job.findings()) + headline(run) +
         "<div class='cards'>" + curl_figure(run.judgement) +
         facts_card(find_table(run.judgement, "recipe")) + slab_part(run, history) + "</div></div>";
}

// Tables that stand in a place of their own: beside a chart or a picture, or as facts.
constexpr std::array<std::string_view, 4> tables_of_histories{"forecast", "warnings", "bottom",
                                                              "pull_in"};
constexpr std::array<std::string_view, 5> placed_tables{"curls", "end", "recipe", "checks",
                                                        "basis"};

/// The histories of the run, and what its last frame shows.
std::string details(const v1::Judgement& judgement) {
  std::string html;
  for (const v1::JudgementPart& part : judgement.parts()) {
    const v1::Table& table = part.table();
    if (part.has_chart() && part.chart().key() != chart_of_first_sheet)
      html += chart_figure(part.chart());
    else if (std::ranges::find(tables_of_histories, table.key()) != tables_of_histories.end())
      // A script draws the gap from the frames of the slab.
      html += table_card(table, table.key() == "bottom" ? "<div class='gap-map'></div>" : "");
  }
  return "<div class='histories'><div class='cards'>" + html + "</div></div>";
}

/// How much of the curl is discretisation: the tables that have no place of their own.
std::string discretisation_part(const v1::Judgement& judgement) {
  std::string html;
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.has_table() &&
        std::ranges::find(placed_tables, part.table().key()) == placed_tables.end() &&
        std::ranges::find(tables_of_histories, part.table().key()) == tables_of_histories.end())
      html += table_card(part.table());
  return html;
}

/// The evidence: error, checks of the run, progress, assumptions and the whole case.
std::string evidence(const ReportedRun& run) {
  return "<div class='evidence'>" + discretisation_part(run.judgement) + "<div class='cards'>" +
         facts_card(find_table(run.judgement, "checks")) + run_table(run.job) + basis_part(run) +
         "</div></div>";
}

/// The result with the last frame; without the frame if there is none, if it exceeds a response, or
/// if the stored results cannot be read.
v1::QueryResultResponse result_of(Connection& connection, const std::string& id,
                                  std::ostream& notes, grpc::Status& status) {
  v1::QueryResultResponse result;
  status = try_query_result(connection, id, LastFrame::drawn, result);
  if (status.ok()) return result;
  notes << "dccast: " << status.error_message()
        << "; the report goes without a picture of the slab\n";
  return query_result(connection, id);
}

/// As many frames as keep the page so small that it can be mailed.
FrameSeries frames_of_page(Connection& connection, const std::string& id,
                           const v1::QueryResultResponse& result) {
  constexpr int most_frames = 25;
  constexpr double most_bytes = 1e6;
  if (!result.has_frame()) return {};
  // The slab grows, so a frame has half the nodes of the last one on average. A node takes some 25
  // characters, with its share of the elements.
  const double nodes = result.frame().temperature_c_size();
  const int fitting = static_cast<int>(most_bytes / (0.5 * 25.0 * nodes + 1.0));
  return fetch_frames(connection, id, result, std::clamp(fitting, 1, most_frames));
}

}  // namespace

std::string report_page(const ReportedRun& run) {
  const figures::RunHistory history = run_history(run.job, run.result);
  const std::string title =
      html_escaped(run.job.title().empty() ? "Casting " + run.job.id() : run.job.title());
  return whole_page(title, page_header(run.job, title),
                    first_sheet(run, history) + details(run.judgement) + evidence(run));
}

std::string report_of(Connection& connection, const v1::Job& job, std::ostream& notes,
                      grpc::Status& frame_status) {
  const v1::QueryResultResponse result = result_of(connection, job.id(), notes, frame_status);
  const v1::Judgement judgement =
      result.steps().empty()
          ? v1::Judgement()
          : judge_run(connection, run_of_job(job.id()),
                      result.has_frame() ? JudgedParts::with_frame : JudgedParts::of_steps);
  return report_page({.job = job,
                      .result = result,
                      .judgement = judgement,
                      .series = frames_of_page(connection, job.id(), result)});
}

}  // namespace dccast::client
