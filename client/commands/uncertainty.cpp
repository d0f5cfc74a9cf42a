#include <algorithm>
#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/html/pages.hpp"
#include "client/model/json.hpp"
#include "client/model/study.hpp"
#include "client/session/data_study.hpp"
#include "client/session/jobs.hpp"
#include "client/session/studies.hpp"
#include "client/text/data_study_text.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/uncertainty.hpp"

namespace dccast::client::commands {
namespace {

/// Options of `uncertainty` and `sensitivity`.
struct DataOptions : StudyOptions {
  DataPlan plan;
  std::string point, band;
};

using LayOut = void (*)(Connection&, const DataPlan&, v1::CreateStudyRequest&);

/// "35..45 mm" as the limits that a case has for it.
void take_band(const std::string& band, std::vector<std::string>& changes) {
  if (band.empty()) return;
  const auto range = case_file::parse_range(band);
  if (!range || !range->suffix.empty())
    throw CommandFailed(ExitCode::invalid, "--band " + band + ": write it as 35..45 mm");
  changes.push_back("plausibility.least_curl=" + range->low);
  changes.push_back("plausibility.greatest_curl=" + range->high);
}

/// The first valid run; of a sensitivity study that is the case itself. Null: there is none.
const v1::StudyRun* first_valid(const v1::StudyResult& result) {
  const auto found = std::ranges::find_if(result.runs(), [](const v1::StudyRun& run) {
    return run.state() == v1::SUCCEEDED && !run.beyond_validity();
  });
  return found == result.runs().end() ? nullptr : &*found;
}

/// Half the band of mesh and time steps relative to the curl.
std::optional<double> mesh_error(const v1::StudyResult& result) {
  const v1::StudyRun* const run = first_valid(result);
  return run && run->has_relative_curl_error() ? std::optional(run->relative_curl_error())
                                               : std::nullopt;
}

/// The error of a small difference between runs, relative to the curl.
std::optional<double> difference_error(Connection& connection, const v1::StudyResult& result) {
  const v1::StudyRun* const run = first_valid(result);
  if (!run) return std::nullopt;
  const v1::Case of_run = query_result(connection, run->job()).case_();
  const auto pair = case_file::paired_error(of_run, of_run);
  return pair ? std::optional(pair->of_curl) : std::nullopt;
}

int chosen_monitor(const v1::StudyResult& result, const std::string& point) {
  const int monitor = monitor_of(result, point);
  if (monitor >= 0) return monitor;
  std::string known;
  for (const std::string& name : result.monitors()) known += "\n  " + name;
  throw CommandFailed(ExitCode::not_found,
                      point.empty() ? "the case has no monitor"
                                    : "no monitor named \"" + point + "\"; there are:" + known);
}

v1::StudyResult spread_of(Connection& connection, const std::string& id, const std::string& point) {
  const v1::StudyResult runs = evaluate_study(connection, id);
  v1::EvaluateStudyRequest request;
  request.set_id(id);
  request.set_spread(runs.monitors(chosen_monitor(runs, point)));
  return connection.call(&Stub::EvaluateStudy, request);
}

void print_uncertainty(Connection& connection, const DataOptions& options, const std::string& id) {
  const v1::StudyResult result = spread_of(connection, id, options.point);
  const auto relative = mesh_error(result);
  if (!options.plot.empty()) write_output(options.plot, render::uncertainty_page(result, relative));
  if (options.json) {
    Json json = to_json(result);
    const auto at_end_m = render::mesh_error_at_end_m(result.spread(), relative);
    json["mesh_error_m"] = at_end_m ? Json(*at_end_m) : Json();
    std::cout << json.dump() << '\n';
  } else if (options.plot != "-") {
    std::cout << render::uncertainty_text(result, relative);
  }
}

Json effects_json(const v1::StudyResult& result, int monitor, std::optional<double> of_curl) {
  const Effects effects = effects_of(result, monitor, of_curl);
  const auto number = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json();
  };
  Json list = Json::array();
  for (const Effect& effect : effects.effects) {
    const auto& axis = result.study().sweep().axes(effect.axis);
    list.push_back({{"key", axis.key()},
                    {"lever", is_lever(axis.key())},
                    {"low", axis.values(0)},
                    {"high", axis.values(1)},
                    {"low_m", number(effect.low_m)},
                    {"high_m", number(effect.high_m)},
                    {"low_failure", effect.low_failure},
                    {"high_failure", effect.high_failure}});
  }
  return {{"study", to_json(result.study())},
          {"monitor", result.monitors(monitor)},
          {"curl_m", number(effects.base_m)},
          {"error_m", number(effects.error_m)},
          {"effects", list}};
}

void print_sensitivity(Connection& connection, const DataOptions& options, const std::string& id) {
  const v1::StudyResult result = evaluate_study(connection, id);
  const int monitor = chosen_monitor(result, options.point);
  const auto of_curl = difference_error(connection, result);
  if (!options.plot.empty())
    write_output(options.plot, render::sensitivity_page(result, monitor, of_curl));
  if (options.json)
    std::cout << effects_json(result, monitor, of_curl).dump() << '\n';
  else if (options.plot != "-")
    std::cout << render::sensitivity_text(result, monitor, of_curl);
}

/// What distinguishes the two commands.
struct Kind {
  const char* name;
  LayOut lay_out;
  void (*print)(Connection&, const DataOptions&, const std::string&);
};

ExitCode run(DataOptions options, const Kind& kind, Program& program) {
  if (options.base.file.empty() == options.study.empty())
    throw CommandFailed(ExitCode::invalid,
                        "give a case FILE to begin, or --study ID to take one up again");
  if (!options.plot.empty() && options.plot != "-") require_free(options.plot, options.force);
  take_band(options.band, options.base.set);
  Connection connection = program.connect();
  std::string id = options.study.empty() ? "" : resolve_study(connection, options.study);
  const std::string come_back = std::string("dccast ") + kind.name + " --study ";
  if (id.empty()) {
    const auto study = create_study(connection, options.base, [&](v1::CreateStudyRequest& request) {
      kind.lay_out(connection, options.plan, request);
    });
    if (!study) return ExitCode::invalid;
    id = study->id();
    std::cerr << "study " << id << ", " << study->runs() << " runs over "
              << study->sweep().axes_size() << " keys; taken up again by " << come_back << id
              << '\n';
    if (options.no_wait) {
      std::cout << id << std::endl;
      return ExitCode::done;
    }
  }
  if (!options.no_wait) follow_with_progress(connection, id, come_back + id);
  kind.print(connection, options, id);
  std::cout << std::flush;
  return ExitCode::done;
}

void add_common(const cli::Command& command, DataOptions& options, const char* plot) {
  command.option("FILE", options.base.file, "Case file");
  command.option("--only", options.plan.only, "Only this datum; repeatable");
  command.option("--point", options.point, "Monitor; absent: that with the largest curl");
  add_study_options(
      command, options,
      {.study = "Take this study up again", .plot = plot, .json = "As JSON, in metres"});
}

}  // namespace

void add_uncertainty(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<DataOptions>();
  const cli::Command command = line.command(
      "uncertainty",
      "How sure a curl is: what the ranges of its data leave open, and which datum to measure "
      "first",
      "dccast uncertainty start-3d.toml --band '35..45 mm'\n"
      "  dccast uncertainty my.toml --runs 100 --only alloy.coherency_solid_fraction\n"
      "  dccast uncertainty --study ID --no-wait      what there is so far\n"
      "\n"
      "Ranges stand in [uncertainty] of case and alloy card (docs/uncertainty.md). The runs are\n"
      "drafts unless --set quality=... chooses another, and wait behind all other jobs.");
  command.option("--runs", options->plan.runs, "Runs of the Latin hypercube")
      .between(8, 10000)
      .show_default();
  command.option("--seed", options->plan.seed, "Its seed").show_default();
  command.option("--band", options->band, "Curls that the plant accepts, as 35..45 mm");
  add_common(command, *options,
             "Write an HTML page with the bands of data and of mesh; - for standard output");
  command.action([options, &program] {
    return run(*options, {"uncertainty", lay_out_uncertainty, print_uncertainty}, program);
  });
}

void add_sensitivity(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<DataOptions>();
  const cli::Command command = line.command(
      "sensitivity",
      "What matters: the change of a curl at the two ends of the range of every lever and datum",
      "dccast sensitivity start-3d.toml --plot sensitivity.html\n"
      "\n"
      "Levers move by a tenth, or by what a plant changes between two castings; data over their\n"
      "[uncertainty] (docs/uncertainty.md). Two drafts for each.");
  add_common(command, *options, "Write an HTML page with a bar for each; - for standard output");
  command.action([options, &program] {
    return run(*options, {"sensitivity", lay_out_sensitivity, print_sensitivity}, program);
  });
}

}  // namespace dccast::client::commands
