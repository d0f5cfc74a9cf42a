#include "client/text/sweep_csv.hpp"

#include <cmath>

#include <fmt/core.h>

#include "client/text/table.hpp"
#include "proto/case_file/key_place.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast::client {
namespace {

/// "_m_per_s": suffix for the unit of a key's numbers; "_factor" and "_si" where they have none.
std::string si_suffix(const std::string& key) {
  if (key.ends_with(".scale")) return "_factor";
  const auto* const field = case_file::field_at(v1::Case(), key);
  const auto suffix =
      field == nullptr ? std::nullopt : case_file::unit_suffix(case_file::key_of(*field).unit());
  return suffix && !suffix->empty() ? std::string(*suffix) : "_si";
}

std::string csv_number(double value) {
  return std::isfinite(value) ? case_file::number_text(value) : "";
}

std::string csv_head(const v1::StudyResult& result) {
  std::string head = "run,job,state";
  for (const auto& axis : result.study().sweep().axes())
    head += "," + csv_text(axis.key()) + "," + csv_text(axis.key() + si_suffix(axis.key()));
  for (const std::string& monitor : result.monitors())
    for (const char* figure : {"_end_curl_m", "_lower_error_m", "_upper_error_m"})
      head += "," + csv_text(monitor + figure);
  return head + ",solver_s,beyond_validity,findings,failure\n";
}

/// A figure of a monitor; empty where it is not known.
std::string csv_figure(const google::protobuf::RepeatedField<double>& by_monitor, int monitor) {
  return monitor < by_monitor.size() ? csv_number(by_monitor[monitor]) : "";
}

std::string csv_row(const v1::StudyRun& run, int number) {
  std::string row = fmt::format("{},{},{}", number, run.job(), v1::JobState_Name(run.state()));
  for (int i = 0; i < run.values_size(); ++i)
    row += "," + csv_text(run.values(i)) + "," + csv_number(run.numbers(i));
  for (int i = 0; i < run.end_curl_m_size(); ++i)
    for (const auto* figures :
         {&run.end_curl_m(), &run.end_lower_error_m(), &run.end_upper_error_m()})
      row += "," + csv_figure(*figures, i);
  return row + fmt::format(",{},{:d},{},{}\n", csv_number(run.solver_s()), run.beyond_validity(),
                           joined(run.findings(), " ", &v1::Finding::code),
                           csv_text(run.failure().message()));
}

}  // namespace

std::string sweep_csv(const v1::StudyResult& result) {
  std::string text = csv_head(result);
  for (int i = 0; i < result.runs_size(); ++i) text += csv_row(result.runs(i), i + 1);
  return text;
}

}  // namespace dccast::client
