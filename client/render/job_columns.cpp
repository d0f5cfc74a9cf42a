#include "client/render/job_columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "client/case_options.hpp"
#include "client/job_id.hpp"
#include "client/render/curl_history.hpp"
#include "client/render/findings.hpp"
#include "client/render/job_text.hpp"
#include "client/render/table.hpp"

namespace dccast::client::render {
namespace {

std::string job_cell(const v1::Job& job) {
  return job.id();
}
std::string done_cell(const v1::Job& job) {
  return job.has_last_step() ? fixed(100.0 * job.last_step().progress(), 0) + " %" : "-";
}

/// Of the monitor with the largest one.
std::string curl_cell(const v1::Job& job) {
  double largest = NAN;
  for (const v1::MonitorValue& monitor : job.last_step().monitors())
    if (!(std::abs(curl_of(monitor)) <= std::abs(largest))) largest = curl_of(monitor);
  return std::isfinite(largest) ? fixed(1e3 * largest, 2) : "-";
}

std::string labels_cell(const v1::Job& job) {
  std::string text;
  for (const std::string& label : job.labels()) text += (text.empty() ? "" : ",") + label;
  return text;
}

std::string findings_cell(const v1::Job& job) {
  return findings_count(job.findings());
}

std::string created_cell(const v1::Job& job) {
  return time_text(job.create_time());
}
std::string changes_cell(const v1::Job& job) {
  return changes_text(job.changes());
}
std::string owner_cell(const v1::Job& job) {
  return job.owner();
}
std::string study_cell(const v1::Job& job) {
  return job.study();
}
std::string title_cell(const v1::Job& job) {
  return job.title();
}

struct Column {
  const char* name;
  const char* heading;
  std::string (*cell)(const v1::Job&);
  bool usual;   ///< shown where no columns are asked for
  bool if_any;  ///< then only if a job has something in it
};
constexpr std::array columns{
    Column{"job", "JOB", job_cell, true, false},
    Column{"state", "STATE", full_state_text, true, false},
    Column{"done", ">DONE", done_cell, true, false},
    Column{"curl", ">CURL mm", curl_cell, true, false},
    Column{"findings", "FINDINGS", findings_cell, true, true},
    Column{"created", "CREATED", created_cell, true, false},
    Column{"labels", "LABELS", labels_cell, true, true},
    Column{"changes", "CHANGES", changes_cell, false, false},
    Column{"owner", "OWNER", owner_cell, false, false},
    Column{"study", "STUDY", study_cell, false, false},
    Column{"title", "TITLE", title_cell, true, false},
};

std::vector<std::string> usual_columns(const std::vector<v1::Job>& jobs) {
  std::vector<std::string> names;
  for (const Column& column : columns) {
    const auto says_something = [&](const v1::Job& job) { return !column.cell(job).empty(); };
    if (column.usual && (!column.if_any || std::ranges::any_of(jobs, says_something)))
      names.emplace_back(column.name);
  }
  return names;
}

const Column& column_of(const std::string& name) {
  return *std::ranges::find(columns, name, [](const Column& c) { return std::string(c.name); });
}

}  // namespace

std::vector<std::string> job_columns() {
  std::vector<std::string> names;
  for (const Column& column : columns) names.emplace_back(column.name);
  return names;
}


std::string job_table(const std::vector<v1::Job>& jobs, std::vector<std::string> names) {
  if (names.empty()) names = usual_columns(jobs);
  std::vector<std::string> headings, ids;
  for (const std::string& name : names) headings.emplace_back(column_of(name).heading);
  for (const v1::Job& job : jobs) ids.push_back(job.id());
  const std::size_t length = short_id_length(ids);
  Table table(headings);
  for (const v1::Job& job : jobs) {
    std::vector<std::string> row;
    for (const std::string& name : names) {
      const std::string cell = column_of(name).cell(job);
      row.push_back(name == "job" ? cell.substr(0, length) : cell);
    }
    table.add(std::move(row));
  }
  return table.text();
}

}  // namespace dccast::client::render
