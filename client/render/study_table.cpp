#include "client/render/study_table.hpp"

#include "client/render/job_text.hpp"
#include "client/render/table.hpp"
#include "client/render/validity.hpp"

namespace dccast::client::render {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string millimetres(double metres) {
  return fixed(1e3 * metres, 3);
}

/// A figure, with a mark if it is beyond validity.
std::string marked(std::string figure, bool valid) {
  return valid ? figure : figure + " !";
}

/// Curl at the end of a level; "-" where it has none.
std::string end_curl(const StudyLevel& level, std::size_t monitor) {
  if (!level.succeeded() || monitor >= level.end_curl_m.size()) return "-";
  return marked(millimetres(level.end_curl_m[monitor]), !level.ends_beyond_validity());
}

}  // namespace

std::vector<std::string> monitor_names(const Study& study) {
  return study.succeeded().empty() ? std::vector<std::string>{} : study.monitor_names;
}

Rows level_rows(const Study& study) {
  Rows rows;
  for (const StudyLevel& level : study.levels) {
    const v1::StepReport& last = level.job.last_step();
    auto& row = rows.emplace_back();
    row = {std::to_string(level.refinement), std::to_string(last.nodes()),
           fixed(last.solver_s(), 1), full_state_text(level.job)};
    for (std::size_t k = 0; k < monitor_names(study).size(); ++k) row.push_back(end_curl(level, k));
  }
  return rows;
}

Rows limit_rows(const Study& study) {
  Rows rows{{"order", "", "", ""},
            {"limit", "", "", ""},
            {"+-", "", "", ""},
            {"+- at most", "", "", ""},
            {"at s", "", "", ""}};
  for (const MonitorStudy& monitor : study.monitors) {
    const CurveLimit& limit = monitor.limit;
    const std::size_t worst = monitor.least_certain();
    rows[0].push_back(limit.order ? fixed(*limit.order, 2) : "none");
    const bool valid = study.valid_at(study.time_s.back());
    rows[1].push_back(marked(millimetres(limit.value_m.back()), valid));
    rows[2].push_back(marked(millimetres(limit.uncertainty_m.back()), valid));
    rows[3].push_back(
        marked(millimetres(limit.uncertainty_m[worst]), study.valid_at(study.time_s[worst])));
    rows[4].push_back(fixed(study.time_s[worst], 2));
  }
  return study.monitors.empty() ? Rows{} : rows;
}

std::string validity_note(const Study& study) {
  if (!study.valid_until_s) return {};
  return std::string("! ") + beyond_validity + ", not an answer: from " +
         fixed(*study.valid_until_s, 2) + " s on the model of at least one level is not valid";
}

std::string study_table(const Study& study) {
  std::vector<std::string> headings{">refinement", ">nodes", ">solver s", "state"};
  for (const std::string& name : monitor_names(study)) headings.push_back(">" + name + " mm");
  Table table(headings);
  for (auto& row : level_rows(study)) table.add(std::move(row));
  for (auto& row : limit_rows(study)) table.add(std::move(row));
  const std::string note = validity_note(study);
  return table.text() + (note.empty() ? note : note + "\n");
}

}  // namespace dccast::client::render
