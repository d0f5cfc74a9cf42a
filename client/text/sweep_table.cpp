#include "client/text/sweep_table.hpp"

#include <cmath>

#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::client::render {
namespace {

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string csv_number(double value) {
  return std::isfinite(value) ? case_file::number_text(value) : "";
}

std::string csv_head(const v1::StudyResult& result) {
  std::string head = "run,job,state";
  for (const auto& axis : result.study().sweep().axes())
    head += "," + csv_text(axis.key()) + "," + csv_text(axis.key() + "_si");
  for (const std::string& monitor : result.monitors())
    head += "," + csv_text(monitor + "_end_curl_m");
  return head + ",solver_s,beyond_validity,findings,failure\n";
}

std::string finding_codes(const v1::StudyRun& run) {
  std::string codes;
  for (const v1::Finding& finding : run.findings())
    codes += (codes.empty() ? "" : " ") + finding.code();
  return codes;
}

std::string csv_row(const v1::StudyRun& run, int number) {
  std::string row = std::to_string(number) + "," + run.job() + "," + v1::JobState_Name(run.state());
  for (int i = 0; i < run.values_size(); ++i)
    row += "," + csv_text(run.values(i)) + "," + csv_number(run.numbers(i));
  for (const double curl : run.end_curl_m()) row += "," + csv_number(curl);
  return row + "," + csv_number(run.solver_s()) + "," + (run.beyond_validity() ? "1" : "0") + "," +
         finding_codes(run) + "," + csv_text(run.failure().message()) + "\n";
}

}  // namespace

std::string run_text(const v1::StudyRun& run) {
  std::string text =
      run.job().empty() && run.state() == v1::QUEUED ? "waiting" : state_text(run.state());
  if (run.has_failure()) text += ": " + failure_kind_text(run.failure().kind());
  if (run.beyond_validity()) text += std::string(", ") + beyond_validity;
  int findings = 0;
  for (const v1::Finding& finding : run.findings())
    if (finding.severity() > v1::Finding::NOTE) ++findings;
  if (findings > 0)
    text += ", " + std::to_string(findings) + (findings == 1 ? " finding" : " findings");
  return text;
}

std::string sweep_table(const v1::StudyResult& result) {
  std::vector<std::string> headings{">run"};
  for (const auto& axis : result.study().sweep().axes()) headings.push_back(">" + axis.key());
  for (const std::string& monitor : result.monitors()) headings.push_back(">" + monitor + " mm");
  headings.push_back("state");
  Table table(headings);
  for (int i = 0; i < result.runs_size(); ++i) {
    const v1::StudyRun& run = result.runs(i);
    std::vector<std::string> row{std::to_string(i + 1)};
    for (const std::string& value : run.values()) row.push_back(value);
    for (const double curl : run.end_curl_m()) row.push_back(fixed(1e3 * curl, 3));
    row.push_back(run_text(run));
    table.add(std::move(row));
  }
  return table.text();
}

std::string sweep_csv(const v1::StudyResult& result) {
  std::string text = csv_head(result);
  for (int i = 0; i < result.runs_size(); ++i) text += csv_row(result.runs(i), i + 1);
  return text;
}

}  // namespace dccast::client::render
