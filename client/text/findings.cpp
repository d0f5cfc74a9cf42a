#include "client/text/findings.hpp"

#include <algorithm>
#include <vector>

#include <fmt/core.h>

#include "client/html/html_parts.hpp"
#include "client/text/job_text.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/remedies.hpp"

namespace dccast::client {
namespace {

std::string severity_text(v1::Finding::Severity severity) {
  return severity == v1::Finding::DANGER    ? "danger"
         : severity == v1::Finding::WARNING ? "warning"
                                            : "note";
}

/// A value [`unit`] with three digits, as limits have; lengths in millimetres: "4.13 mm", "0.98",
/// "622 degC".
std::string figure_text(double value, const std::string& unit) {
  const bool length = unit == "m";
  std::string text = fmt::format("{:.3g}", length ? 1e3 * value : value);
  if (!unit.empty() && unit != "1") text += " " + (length ? "mm" : unit);
  return text;
}

/// "1 danger", "2 dangers".
std::string count_text(const Findings& findings, v1::Finding::Severity severity) {
  const auto count = std::ranges::count(findings, severity, &v1::Finding::severity);
  if (count == 0) return {};
  return std::to_string(count) + " " + severity_text(severity) + (count == 1 ? "" : "s");
}

void append(std::string& list, const std::string& text, const char* separator) {
  if (!text.empty()) list += (list.empty() ? "" : separator) + text;
}

/// Whether a finding became worse after it was raised.
bool became_worse(const v1::Finding& finding) {
  const auto& worst = finding.worst();
  return finding.has_worst() &&
         (worst.time_s() != finding.time_s() || worst.value() != finding.value());
}

/// The message, of when the finding was raised, after the worst that came: what a reader needs
/// first.
std::string message_text(const v1::Finding& finding) {
  if (!became_worse(finding)) return finding.message();
  return fmt::format("At worst {}, at {} s. {}",
                     figure_text(finding.worst().value(), finding.unit()),
                     fixed(finding.worst().time_s(), 2), finding.message());
}

/// Value, limit, place, that of the worst value, and key, where known.
std::string particulars(const v1::Finding& finding) {
  std::string text;
  if (finding.has_value()) text = figure_text(finding.value(), finding.unit());
  if (finding.has_limit())
    append(text, "limit " + figure_text(finding.limit(), finding.unit()), ", ");
  append(text, place_text(finding.place_m()), "; ");
  if (became_worse(finding) && !finding.worst().place_m().empty())
    append(text, "worst at " + place_text(finding.worst().place_m()), "; ");
  append(text, finding.key(), "; ");
  return text;
}

std::string when(const v1::Finding& finding) {
  return finding.has_time_s() ? fixed(finding.time_s(), 2) + " s" : "";
}

/// What helps, where it is sure, or what computes it.
std::string remedy_of(const v1::Finding& finding) {
  if (!finding.remedy().empty()) return " " + finding.remedy();
  return case_file::advice_against(finding).empty() ? "" : " dccast remedy computes what helps.";
}

std::string html_row(const v1::Finding& finding) {
  return fmt::format(
      "<tr class='{0}'><th scope='row'>{0}</th><td>{1} <b>{2}</b><small>{3}; {4}</small></td>"
      "<td>{5}</td></tr>",
      severity_text(finding.severity()), html_escaped(message_text(finding)),
      html_escaped(finding.remedy()), html_escaped(finding.code()),
      html_escaped(particulars(finding)), when(finding));
}

}  // namespace

std::string finding_line(const v1::Finding& finding) {
  const std::string time = when(finding), more = particulars(finding);
  return severity_text(finding.severity()) + ": " + finding.code() +
         (time.empty() ? "" : " at " + time) + ": " + message_text(finding) + remedy_of(finding) +
         (more.empty() ? "" : " [" + more + "]");
}

std::string findings_count(const Findings& findings) {
  std::string text;
  for (const auto severity : {v1::Finding::DANGER, v1::Finding::WARNING, v1::Finding::NOTE})
    append(text, count_text(findings, severity), ", ");
  return text;
}

bool more_than_notes(const Findings& findings) {
  return std::ranges::any_of(
      findings, [](const v1::Finding& finding) { return finding.severity() > v1::Finding::NOTE; });
}

std::string findings_part(const Findings& findings) {
  const std::string purpose =
      "Screening and advice, not a safety system: the limits of your plant hold.";
  if (findings.empty())
    return "<p class='note'>Findings: none (docs/findings.md). " + purpose + "</p>";

  std::vector<const v1::Finding*> ordered;
  for (const v1::Finding& finding : findings) ordered.push_back(&finding);
  std::ranges::stable_sort(ordered, std::ranges::greater{}, &v1::Finding::severity);
  std::string rows;
  for (const v1::Finding* finding : ordered) rows += html_row(*finding);
  return "<section class='card findings'><h2>Findings: " + findings_count(findings) +
         "</h2><table>" + rows +
         "</table><p class='soft'>What each means, its limit and where that comes from: "
         "docs/findings.md. " +
         purpose + "</p></section>";
}

std::string place_text(const google::protobuf::RepeatedField<double>& place_m) {
  constexpr int axes = 3;
  std::string text;
  for (int i = 0; i < std::min(place_m.size(), axes); ++i)
    append(text, fmt::format("{} {} mm", "xyz"[i], mm(place_m[i])), ", ");
  return text;
}

std::string validity_text(const v1::Finding& loss) {
  const std::string begin =
      fmt::format("{} from {} s on: ", beyond_validity, fixed(loss.time_s(), 2));
  if (!loss.message().empty()) return begin + loss.message();  // has place and amount
  std::string text = begin + failure_kind_text(loss.kind());
  if (loss.limit() != 0.0 || loss.value() != 0.0)
    text += " (" + figure_text(loss.value(), loss.unit()) + ", limit " +
            figure_text(loss.limit(), loss.unit()) + ")";
  const std::string place = place_text(loss.place_m());
  return place.empty() ? text : text + " at " + place;
}

}  // namespace dccast::client
