#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/model/answer.hpp"
#include "client/session/download.hpp"
#include "client/session/plan_requests.hpp"
#include "client/session/studies.hpp"
#include "client/text/job_text.hpp"
#include "client/text/study_text.hpp"
#include "client/text/sweep_csv.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/quality.hpp"

namespace dccast::client {
namespace {

struct StudiesOptions {
  int limit = 50;
  std::vector<std::string> labels;
  bool mine = false;
  std::string id;
  std::string reason;
  std::string output = "study.h5";
  bool failed = false;
  bool force = false;
  bool json = false;
};

ExitCode list(const StudiesOptions& options, Program& program) {
  Connection connection = program.connect();
  v1::ListStudiesRequest request;
  request.mutable_labels()->Assign(options.labels.begin(), options.labels.end());
  if (options.mine) request.set_owner(user_name(connection));
  const auto studies = list_studies(connection, std::move(request), options.limit);
  if (options.json) {
    print_line(json_list(studies, to_json));
    return ExitCode::done;
  }

  // Ids are cut to the length that still tells these studies apart.
  std::vector<std::string> ids;
  for (const v1::Study& study : studies) ids.push_back(study.id());
  const std::size_t length = short_id_length(ids);

  Table table({"STUDY", "STATE", "RUNS", "PLAN", "CREATED", "TITLE"});
  for (const v1::Study& study : studies)
    table.add({study.id().substr(0, length), state_text(study), progress_text(study),
               plan_text(study), time_text(study.create_time()), study.title()});
  if (studies.empty())
    std::cerr << "no studies\n";
  else
    std::cout << table.text();
  return ExitCode::done;
}

ExitCode print(const StudiesOptions& options, const v1::Study& study) {
  std::cout << (options.json ? to_json(study).dump() + "\n" : study_sheet(study));
  return ExitCode::done;
}

ExitCode show(const StudiesOptions& options, Program& program) {
  Connection connection = program.connect();
  return print(options, connection.call(&Stub::GetStudy, resolve_study(connection, options.id)));
}

ExitCode fetch(const StudiesOptions& options, Program& program) {
  require_free(options.output, options.force);
  Connection connection = program.connect();
  const std::string id = resolve_study(connection, options.id);
  const Download table = download_study(connection, id, options.output, std::cerr);
  if (options.json)
    print_line(
        {{"id", id}, {"file", options.output}, {"bytes", table.bytes}, {"sha256", table.sha256}});
  else
    std::cout << table.sha256 << "  " << options.output << '\n';
  return ExitCode::done;
}

ExitCode cancel(const StudiesOptions& options, Program& program) {
  Connection connection = program.connect();
  v1::CancelStudyRequest request;
  request.set_id(resolve_study(connection, options.id));
  request.set_reason(options.reason);
  return print(options, connection.call(&Stub::CancelStudy, request));
}

ExitCode resume(const StudiesOptions& options, Program& program) {
  Connection connection = program.connect();
  v1::ResumeStudyRequest request;
  request.set_id(resolve_study(connection, options.id));
  request.set_failed(options.failed);
  return print(options, connection.call(&Stub::ResumeStudy, request));
}

ExitCode remove(const StudiesOptions& options, Program& program) {
  Connection connection = program.connect();
  v1::DeleteStudyRequest request;
  request.set_id(resolve_study(connection, options.id));
  connection.call_once(&Stub::DeleteStudy, request);
  if (options.json)
    print_line({{"id", request.id()}, {"deleted", true}});
  else
    std::cerr << "deleted " << request.id() << " and its jobs\n";
  return ExitCode::done;
}

Command add_action(const Command& command, Program& program, StudiesOptions& options,
                   const std::string& name, const std::string& description,
                   ExitCode (*run)(const StudiesOptions&, Program&)) {
  const Command added = command.command(name, description);
  added.option("STUDY", options.id, study_help, required);
  added.json(options.json);
  added.action([&options, &program, run] { return run(options, program); });
  return added;
}

struct SweepOptions : StudyOptions {  // its file may be a sweep file
  std::vector<std::string> grid, list;
  int hypercube = 0;
  std::uint64_t seed = 0;
  std::string csv, output;
};

/// The plan given on the command line.
v1::SweepPlan plan_of(const SweepOptions& options) {
  v1::SweepPlan plan;
  const auto& axes = options.list.empty() ? options.grid : options.list;
  for (const std::string& axis : axes) *plan.add_axes() = axis_of(axis);
  plan.set_design(options.hypercube > 0  ? v1::SweepPlan::LATIN_HYPERCUBE
                  : options.list.empty() ? v1::SweepPlan::GRID
                                         : v1::SweepPlan::LIST);
  plan.set_runs(options.hypercube);
  plan.set_seed(options.seed);
  return plan;
}

/// The case file and the plan, from a sweep file or from the command line.
SweepFile sweep_of(const SweepOptions& options) {
  const bool by_command = !options.grid.empty() || !options.list.empty();
  if (by_command) return {options.base.file, plan_of(options)};
  if (is_sweep_file(options.base.file)) return read_sweep_file(options.base.file);
  throw invalid(options.base.file +
                ": has no [[axis]]; give a sweep file, or keys of the case by --grid KEY=a,b,c");
}

std::optional<v1::Study> create(Connection& connection, const SweepOptions& options) {
  const SweepFile sweep = sweep_of(options);
  return create_study(
      connection,
      {sweep.case_file, options.base.set, options.base.labels,
       !options.list.empty()   ? "--list"
       : !options.grid.empty() ? "--grid"
                               : options.base.file + ", axis"},
      [&](v1::CreateStudyRequest& request) { *request.mutable_sweep() = sweep.plan; });
}

ExitCode wait_and_print(Connection& connection, const SweepOptions& options,
                        const std::string& id) {
  if (!options.no_wait) follow_with_progress(connection, id, "dccast sweep --study " + id);
  const v1::StudyJudgement answer = judge_study(connection, {.id = id, .curves = options.json});
  if (!options.csv.empty()) write_output(options.csv, sweep_csv(answer.result()));
  print_answer(options, answer, options.csv);

  if (!options.output.empty()) {
    const Download table = download_study(connection, id, options.output, std::cerr);
    std::cerr << "wrote " << options.output << " (" << table.bytes
              << " bytes, checksum verified)\n";
  }
  return exit_code_of(answer, answer.study().state() == v1::STUDY_SUCCEEDED);
}

ExitCode run(const SweepOptions& options, Program& program) {
  if (options.base.file.empty() == options.study.empty())
    throw invalid("give a sweep FILE or a case to begin, or --study ID to take one up again");
  for (const std::string& file : {options.csv, options.plot, options.output})
    require_free(file, options.force);
  Connection connection = program.connect();
  if (!options.study.empty())
    return wait_and_print(connection, options, resolve_study(connection, options.study));
  const auto study = create(connection, options);
  if (!study) return ExitCode::invalid;
  std::cerr << "study " << study->id() << ", " << study->runs()
            << " runs; taken up again by dccast sweep --study " << study->id() << '\n';
  if (options.no_wait) {
    std::cout << study->id() << std::endl;
    return ExitCode::done;
  }
  return wait_and_print(connection, options, study->id());
}

constexpr const char* sweep_examples =
    R"(dccast sweep my.toml --grid 'schedule.casting_speed=40 mm/min,60 mm/min,70 mm/min'
  dccast sweep my.toml --grid 'schedule.casting_speed=40 mm/min,80 mm/min' \
      --grid schedule.water_flow.scale=0.7,1.2 --lhs 40 --plot sweep.html
  dccast sweep SWEEP.toml --csv sweep.csv           case, design and keys in a file
  dccast sweep --study ID --no-wait --json          what there is so far, with the curves

docs/studies.md has the format of a sweep file. The runs wait behind all other jobs; dccast
studies cancels and resumes them, dccast predict answers for values that were not run.)";

struct PredictOptions {
  std::string id;
  std::vector<std::string> set;
  bool json = false;
};

void print(const v1::Prediction& prediction) {
  std::vector<std::string> headings{"monitor", ">curl mm", ">surface \u00b1 mm"};
  const bool has_error = !prediction.end_upper_error_m().empty();
  if (has_error) headings.push_back(">mesh and steps mm");
  headings.insert(headings.end(), {">at s", ">cast mm"});
  Table table(headings);

  for (int i = 0; i < prediction.curves_size(); ++i) {
    const v1::CurlCurve& curve = prediction.curves(i);
    const int last = curve.time_s_size() - 1;
    if (last < 0 || !std::isfinite(curve.curl_m(last))) continue;
    // The larger of the two errors determines the number of digits of the curl.
    const double curl_m = curve.curl_m(last), surface_m = curve.uncertainty_m(last);
    const bool is_known = has_error && std::isfinite(prediction.end_upper_error_m(i));
    const double lower_m = is_known ? prediction.end_lower_error_m(i) : 0.0;
    const double upper_m = is_known ? prediction.end_upper_error_m(i) : 0.0;
    const int decimals = mm_decimals(std::max({surface_m, lower_m, upper_m}));

    std::vector<std::string> row{curve.monitor(), mm(curl_m, decimals), mm(surface_m, decimals)};
    if (has_error) row.push_back(is_known ? mm_errors(lower_m, upper_m, decimals) : "-");
    row.push_back(fixed(curve.time_s(last), 2));
    row.push_back(fixed(1e3 * curve.cast_length_m(last), 1));
    table.add(std::move(row));
  }

  std::cout << table.text() << std::flush;
  std::cerr << "from " << prediction.runs() << " runs; leave-one-out error "
            << mm(prediction.cross_validated_error_m(), 2) << " mm (root mean square)\n";

  if (prediction.next_run().empty()) return;
  std::cerr << "most informative next run:";
  for (const v1::CaseChange& change : prediction.next_run())
    std::cerr << " --set '" << change.key() << "=" << change.value() << "'";
  std::cerr << '\n';
}

ExitCode run(const PredictOptions& options, Program& program) {
  Connection connection = program.connect();
  v1::PredictStudyRequest request;
  request.set_id(resolve_study(connection, options.id));
  const auto values = changes_of(options.set);
  *request.mutable_values() = {values.begin(), values.end()};
  const v1::Prediction prediction = connection.call(&Stub::PredictStudy, request);
  if (options.json)
    print_line(to_json(prediction));
  else
    print(prediction);
  return ExitCode::done;
}

}  // namespace

void add_studies(CommandLine& line, Program& program) {
  const auto [command, options] = declare<StudiesOptions>(
      line, program, list, "studies",
      "List studies, newest first; show, fetch, cancel, resume or delete one",
      "dccast studies --mine\n  dccast studies --label trial-7 --json | jq -r '.[].id'\n"
      "  dccast studies cancel STUDY\n  dccast studies resume --failed STUDY");

  command.repeatable("--label", options.labels, "Only studies with this label; repeatable",
                     {.comma_separated = true});
  command.flag("--mine", options.mine, "Only your own studies");
  command.number("-n,--limit", options.limit, 1, 1000000, "At most this many");
  command.json(options.json);
  add_action(command, program, options, "show", "Everything about one study", show);

  const Command fetched = add_action(
      command, program, options, "fetch",
      "Fetch values, curls, curves, states and findings of all runs as HDF5 (docs/studies.md)",
      fetch);
  fetched.option("-o,--output", options.output, "File to write", shown);
  add_force_flag(fetched, options.force);

  add_action(command, program, options, "cancel", "Cancel what has not ended", cancel)
      .option("--reason", options.reason, "Kept with the jobs");
  add_action(command, program, options, "resume",
             "Queue runs again that were cancelled, or lost to their worker or a full disk", resume)
      .flag("--failed", options.failed, "Also runs that failed by their own case");
  add_action(command, program, options, "delete", "Remove an ended study and its jobs", remove);
}

void add_sweep(CommandLine& line, Program& program) {
  const auto [command, options] = declare<SweepOptions>(
      line, program, run, "sweep", "Run a case at many values of its keys, and compare the curl",
      sweep_examples);

  command.option("FILE", options.base.file, "Sweep file, or with --grid or --list a case file");
  command.option("--grid", options.grid,
                 "KEY=a,b,c: every value with those of the other keys; repeatable");
  command.option("--list", options.list,
                 "KEY=a,b,c: the first values of all keys, the second ones, ...",
                 {.excludes = {"--grid"}});
  command.option("--lhs", options.hypercube,
                 "Number of runs of a Latin hypercube between the two values of each --grid",
                 {.between = {{1, 10000}}, .excludes = {"--list"}});
  command.option("--seed", options.seed, "Seed of the Latin hypercube", shown);

  command.option("--csv", options.csv, "Write the table as CSV; - for standard output");
  command.option("-o,--output", options.output,
                 "Write values, curls, curves, states and findings as HDF5 (docs/studies.md)");
  add_study_options(
      command, options,
      {.study = "Take this study up again",
       .plot = "Write an HTML page with the curl against the keys; - for standard output",
       .json = "As JSON, in metres, with the curves"});
}

void add_predict(CommandLine& line, Program& program) {
  const auto [command, options] = declare<PredictOptions>(
      line, program, run, "predict",
      "The curl at values that a sweep has not run, from a response surface over its runs. It "
      "covers the range of the sweep and nothing outside. The standard error of the surface and "
      "what mesh and time steps of the runs leave uncertain are given apart",
      "dccast predict STUDY --set 'schedule.casting_speed=53 mm/min' --set "
      "schedule.water_flow.scale=0.9");
  command.option("STUDY", options.id, study_help, required);
  command.option("--set", options.set,
                 "KEY=VALUE of a swept key; others keep the value of the case");
  command.json(options.json, "As JSON, in metres, with the curves against time");
}

}  // namespace dccast::client
