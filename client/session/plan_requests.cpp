#include "client/session/plan_requests.hpp"

#include <toml++/toml.h>

#include <filesystem>
#include <map>
#include <optional>
#include <sstream>

#include "client/session/connection.hpp"
#include "client/session/failure.hpp"
#include "client/session/jobs.hpp"
#include "client/session/studies.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/frames/contraction.hpp"

namespace dccast::client {
namespace {

const std::map<std::string, v1::SweepPlan::Design> designs{
    {"grid", v1::SweepPlan::GRID},
    {"list", v1::SweepPlan::LIST},
    {"latin_hypercube", v1::SweepPlan::LATIN_HYPERCUBE}};

[[noreturn]] void refuse(const std::string& file, const std::string& fault) {
  throw CommandFailed(ExitCode::invalid, file + ": " + fault);
}

std::optional<toml::table> parsed(const std::string& file) {
  try {
    return toml::parse_file(file);
  } catch (const toml::parse_error&) {
    return std::nullopt;
  }
}

/// The value as a case file would have it.
std::string written(const toml::node& node) {
  if (const auto text = node.value_exact<std::string>()) return *text;
  std::ostringstream stream;
  node.visit([&stream](const auto& value) { stream << value; });
  return stream.str();
}

v1::SweepPlan::Axis read_axis(const std::string& file, const toml::node& node) {
  const toml::table* const table = node.as_table();
  if (table == nullptr) refuse(file, "axis: write [[axis]] with key and values");
  v1::SweepPlan::Axis axis;
  axis.set_key((*table)["key"].value_or(std::string()));
  if (axis.key().empty()) refuse(file, "axis.key is absent, e.g. key = \"schedule.casting_speed\"");
  const toml::array* const values = (*table)["values"].as_array();
  if (values == nullptr)
    refuse(file, "axis.values of " + axis.key() + ": permitted: a list, e.g. [\"40 mm/min\"]");
  for (const toml::node& value : *values) axis.add_values(written(value));
  return axis;
}

}  // namespace

bool is_sweep_file(const std::string& file) {
  const auto table = parsed(file);
  return table && table->contains("axis");
}

SweepFile read_sweep_file(const std::string& file) {
  const auto table = parsed(file);
  if (!table) refuse(file, "is no TOML file");
  for (const auto& [key, value] : *table)
    if (key != "case" && key != "design" && key != "runs" && key != "seed" && key != "axis")
      refuse(file,
             std::string(key.str()) + ": unknown key; permitted: case, design, runs, seed, axis");
  SweepFile sweep;
  const std::string of_case = (*table)["case"].value_or(std::string());
  if (of_case.empty()) refuse(file, "case is absent: the case file that is swept");
  sweep.case_file = (std::filesystem::path(file).parent_path() / of_case).string();
  const auto design = designs.find((*table)["design"].value_or(std::string("grid")));
  if (design == designs.end()) refuse(file, "design: permitted: grid, list, latin_hypercube");
  sweep.plan.set_design(design->second);
  sweep.plan.set_runs(static_cast<int>((*table)["runs"].value_or(std::int64_t{0})));
  sweep.plan.set_seed(static_cast<std::uint64_t>((*table)["seed"].value_or(std::int64_t{0})));
  const toml::array* const axes = (*table)["axis"].as_array();
  if (axes == nullptr) refuse(file, "axis: write [[axis]] with key and values");
  for (const toml::node& axis : *axes) *sweep.plan.add_axes() = read_axis(file, axis);
  return sweep;
}

v1::SweepPlan::Axis axis_of(std::string_view text) {
  const auto equals = text.find('=');
  if (equals == std::string_view::npos || equals == 0)
    throw CommandFailed(ExitCode::invalid,
                        "\"" + std::string(text) + "\": write KEY=a,b,c, e.g. mesh.rows=20,30,40");
  v1::SweepPlan::Axis axis;
  axis.set_key(std::string(case_file::trimmed(text.substr(0, equals))));
  std::string value;
  int depth = 0;
  bool quoted = false;
  for (const char c : text.substr(equals + 1)) {
    if (c == '"') quoted = !quoted;
    if (!quoted && c == '[') ++depth;
    if (!quoted && c == ']') --depth;
    if (c == ',' && depth == 0 && !quoted) {
      axis.add_values(std::string(case_file::trimmed(value)));
      value.clear();
    } else {
      value += c;
    }
  }
  axis.add_values(std::string(case_file::trimmed(value)));
  return axis;
}

namespace {

void read_cast(Connection& connection, MouldRun& run) {
  v1::QueryResultResponse result;
  const grpc::Status status = try_query_result(connection, run.job, true, result);
  if (!status.ok()) {
    run.reason = status.error_message();
    return;
  }
  try {
    run.cast =
        CastMould{result.case_().section(),
                  frames::steady_face(frames::contraction_of(result.case_(), result.frame()))};
  } catch (const frames::NoContraction& reason) {
    run.reason = reason.what();
  }
}

/// The value of the plan, or the opening at the narrow face of the mould that the first run had.
double wanted_of(const v1::MouldPlan& plan, const std::vector<MouldRun>& runs) {
  if (plan.wanted_half_thickness_m() > 0.0) return plan.wanted_half_thickness_m();
  if (runs.empty() || !runs.front().cast) return 0.0;
  const v1::Section& section = runs.front().cast->section;
  return frames::half_opening_m(section, section.half_width_m());
}

}  // namespace

const MouldRun* MouldDesign::best() const {
  const MouldRun* best = nullptr;
  for (const MouldRun& run : runs)
    if (run.cast && (best == nullptr ||
                     run.cast->face.residual_m(wanted_m) < best->cast->face.residual_m(wanted_m)))
      best = &run;
  return best;
}

bool MouldDesign::steady() const {
  const MouldRun* run = best();
  return run != nullptr && run->cast->face.change_m <= result.study().mould().tolerance_m();
}

MouldDesign read_mould_design(Connection& connection, const std::string& study) {
  MouldDesign design{evaluate_study(connection, study), 0.0, {}};
  if (!design.result.study().has_mould())
    throw CommandFailed(
        ExitCode::invalid,
        "study " + study + " designs no mould; dccast studies show " + study + " shows what it is");
  for (const v1::StudyRun& run : design.result.runs()) {
    MouldRun& read = design.runs.emplace_back();
    read.job = run.job();
    read.state = run.state();
    read.reason = run.failure().message();
    if (run.state() == v1::SUCCEEDED) read_cast(connection, read);
  }
  design.wanted_m = wanted_of(design.result.study().mould(), design.runs);
  return design;
}

}  // namespace dccast::client
