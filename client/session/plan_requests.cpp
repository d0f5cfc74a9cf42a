#include "client/session/plan_requests.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "client/session/connection.hpp"
#include "client/session/data_study.hpp"
#include "client/session/failure.hpp"
#include "client/session/jobs.hpp"
#include "client/session/studies.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/recipe_numbers.hpp"
#include "proto/case_file/schedule.hpp"
#include "proto/case_file/uncertainty.hpp"

namespace dccast::client {
namespace {

const std::map<std::string, v1::SweepPlan::Design> designs{
    {"grid", v1::SweepPlan::GRID},
    {"list", v1::SweepPlan::LIST},
    {"latin_hypercube", v1::SweepPlan::LATIN_HYPERCUBE}};

[[noreturn]] void refuse(const std::string& file, const std::string& fault) {
  throw invalid(file + ": " + fault);
}

std::optional<toml::table> parsed(const std::string& file) {
  try {
    return toml::parse_file(file);
  } catch (const toml::parse_error&) {
    return std::nullopt;
  }
}

/// A value as written in a case file.
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

using case_file::RecipeNumber;

struct Ends {
  double low, high;
};

[[noreturn]] void refuse(const std::string& option, const std::string& text,
                         const std::string& why) {
  throw invalid(option + " " + text + ": " + why);
}

/// @param whole  text of the option that contains the quantity; empty: the quantity itself
double quantity_of(const std::string& option, const std::string& text, const std::string& unit,
                   const std::string& whole = {}) {
  const case_file::Quantity quantity = case_file::parse_quantity(text, unit);
  if (!quantity.value) refuse(option, whole.empty() ? text : whole, quantity.message);
  return *quantity.value;
}

Ends ends_of(const std::string& option, const std::string& text, const std::string& unit) {
  const auto range = case_file::parse_range(text);
  if (!range || !range->suffix.empty()) refuse(option, text, "write it as 20..80 with its unit");
  const Ends ends{quantity_of(option, range->low, unit, text),
                  quantity_of(option, range->high, unit, text)};
  if (!(ends.low >= 0.0)) refuse(option, text, "permitted: 0 or more");
  return ends;
}

/// A number of a recipe, the option that limits it, and its permitted range relative to the case.
struct Limited {
  RecipeNumber number;
  const char* option;
  std::string text;
  const char* unit;
  double least_share, greatest_share;
};

void add_number(const Limited& limited, double value, v1::RecipePlan& plan) {
  if (!(value > 0.0)) return;  // the case does without it
  const std::string name = case_file::recipe_names[limited.number];
  const Ends limits = ends_of(limited.option, limited.text, limited.unit);
  const Ends ends{std::max(limited.least_share * value, limits.low),
                  std::min(limited.greatest_share * value, limits.high)};
  if (!(ends.low < ends.high))
    refuse(
        limited.option, limited.text,
        name + " of the case is " + case_file::number_text(value) + " " + limited.unit +
            ", and nothing near it is inside this limit; change the limit, the case, or --within");
  v1::RecipePlan::Number& number = *plan.add_numbers();
  number.set_name(name);
  number.set_low(ends.low);
  number.set_high(ends.high);
}

void add_numbers(const v1::Case& complete, const RecipeChoice& choice, v1::RecipePlan& plan) {
  const double within = 0.01 * choice.within_percent;

  const auto level = [&](RecipeNumber number, const char* option, const std::string& text,
                         const char* unit) -> Limited {
    return {number, option, text, unit, 1.0 - within, 1.0 + within};
  };
  // A ramp against cast length is not limited by a time.
  const auto ramp = [&](RecipeNumber number, const v1::Curve& curve) -> Limited {
    if (case_file::is_by_length(curve)) return {number, "--ramp", "0..10 m", "m", 0.5, 2.0};
    return {number, "--ramp", choice.ramp, "s", 0.5, 2.0};
  };

  std::vector<Limited> numbers{
      level(case_file::speed_start, "--speed", choice.speed, "m/s"),
      level(case_file::speed_run, "--speed", choice.speed, "m/s"),
      ramp(case_file::speed_ramp, complete.schedule().casting_speed_m_per_s()),
      {case_file::filling, "--filling", choice.filling, "s", 0.5, 2.0},
      {case_file::hold, "--hold", choice.hold, "s", 0.5, 2.0}};
  if (complete.cooling().water().enabled())
    numbers.insert(numbers.end(),
                   {level(case_file::water_start, "--water", choice.water, "m2/s"),
                    level(case_file::water_run, "--water", choice.water, "m2/s"),
                    ramp(case_file::water_ramp, complete.schedule().water_flow_m2_per_s())});

  const case_file::Recipe recipe = case_file::recipe_of(complete);
  for (const Limited& number : numbers) add_number(number, recipe[number.number], plan);
}

void add_band(const RecipeChoice& choice, const v1::Case& complete, v1::RecipePlan& plan) {
  if (!choice.band.empty()) {
    const auto range = case_file::parse_range(choice.band);
    if (!range || !range->suffix.empty()) refuse("--band", choice.band, "write it as 35..45 mm");
    plan.set_least_curl_m(quantity_of("--band", range->low, "m", choice.band));
    plan.set_greatest_curl_m(quantity_of("--band", range->high, "m", choice.band));
    return;
  }
  const v1::Plausibility& accepted = complete.plausibility();
  if (!accepted.has_least_curl_m() || !accepted.has_greatest_curl_m())
    throw invalid("give the curls that the plant accepts, e.g. --band \"35..45 mm\"");
  plan.set_least_curl_m(accepted.least_curl_m());
  plan.set_greatest_curl_m(accepted.greatest_curl_m());
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
    throw invalid("\"" + std::string(text) + "\": write KEY=a,b,c, e.g. mesh.rows=20,30,40");

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

void lay_out_recipe(Connection& connection, const RecipeChoice& choice,
                    v1::CreateStudyRequest& request) {
  const v1::Case complete = complete_case(connection, request);
  v1::RecipePlan& plan = *request.mutable_recipe();
  add_band(choice, complete, plan);
  add_numbers(complete, choice, plan);
  plan.set_monitor(choice.point);
  plan.set_line(choice.line);
  plan.set_greatest_speed_rate_m_per_s2(quantity_of("--speed-rate", choice.speed_rate, "m/s2"));
  plan.set_greatest_flow_rate_m2_per_s2(quantity_of("--water-rate", choice.water_rate, "m2/s2"));
  plan.set_drafts(choice.drafts);
  plan.set_castings(choice.castings);
  plan.set_candidates(choice.candidates);
  plan.set_seed(choice.seed);
  request.clear_request_id();
  request.set_find(true);
}

v1::Study remedy_of(Connection& connection, const std::string& job, const std::string& line) {
  v1::CreateStudyRequest request;
  request.set_find(true);
  request.mutable_remedy()->set_job(job);
  request.mutable_remedy()->set_line(line);
  return connection.call(&Stub::CreateStudy, request);
}

v1::Study taken_up(Connection& connection, const v1::Study& study) {
  if (study.state() != v1::STUDY_CANCELLED && study.state() != v1::STUDY_FAILED) return study;
  v1::ResumeStudyRequest request;
  request.set_id(study.id());
  return connection.call_once(&Stub::ResumeStudy, request);
}

void cancel_after_interruption(const Connection& interrupted, const std::string& id) {
  Connection connection = interrupted.another(std::make_shared<Interruption>());
  v1::CancelStudyRequest request;
  request.set_id(id);
  request.set_reason("interrupted");
  connection.call(&Stub::CancelStudy, request);
}

}  // namespace dccast::client
