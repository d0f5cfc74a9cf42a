#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/html/pages.hpp"
#include "client/model/json.hpp"
#include "client/session/failure.hpp"
#include "client/session/plan_requests.hpp"
#include "client/session/studies.hpp"
#include "client/text/study_text.hpp"

namespace dccast::client::commands {
namespace {

struct Options : StudyOptions {
  std::string tolerance = "0.5 mm";
  std::string wanted;
  int most_runs = 0;
  bool flat = false;
};

v1::MouldPlan plan_of(const Options& options) {
  v1::MouldPlan plan;
  plan.set_tolerance_m(metres_of(options.tolerance, "--tolerance"));
  if (!options.wanted.empty())
    plan.set_wanted_half_thickness_m(metres_of(options.wanted, "--wanted"));
  plan.set_maximum_runs(options.most_runs);
  return plan;
}

Json run_json(const MouldDesign& design, const MouldRun& run) {
  Json json{{"job", run.job}, {"state", v1::JobState_Name(run.state)}};
  if (!run.reason.empty()) json["trouble"] = run.reason;
  if (!run.cast) return json;
  const v1::Curve& opening = run.cast->section.half_thickness_m();
  const frames::SteadyFace& face = run.cast->face;
  json["break_point_m"] = std::vector<double>(opening.at().begin(), opening.at().end());
  json["half_opening_m"] = std::vector<double>(opening.value().begin(), opening.value().end());
  json["height_m"] = face.height_m;
  json["change_around_m"] = face.change_m;
  json["x_m"] = face.x_m;
  json["half_thickness_at_20_c_m"] = face.cold_m;
  json["residual_m"] = face.residual_m(design.wanted_m);
  return json;
}

void print_json(const MouldDesign& design) {
  Json json{{"study", to_json(design.result.study())},
            {"wanted_half_thickness_m", design.wanted_m},
            {"found", design.result.has_mould() ? to_json(design.found()) : Json()},
            {"steady", design.steady()},
            {"runs", Json::array()}};
  for (const MouldRun& run : design.runs) json["runs"].push_back(run_json(design, run));
  std::cout << json.dump() << '\n';
}

/// A search that has not ended has not failed. A face that is not steady yet is no prediction.
ExitCode exit_code_of(const MouldDesign& design) {
  if (design.result.study().state() == v1::STUDY_RUNNING) return ExitCode::done;
  return design.found().within_tolerance() && design.steady() ? ExitCode::done
                                                              : ExitCode::solve_failed;
}

ExitCode wait_and_print(Connection& connection, const Options& options, const std::string& id) {
  if (!options.no_wait) follow_with_progress(connection, id, "dccast design-mould --study " + id);
  const MouldDesign design = read_mould_design(connection, id);
  if (!options.plot.empty()) write_output(options.plot, render::mould_page(design));
  if (options.json)
    print_json(design);
  else if (options.plot != "-")
    std::cout << render::mould_text(design);
  std::cout << std::flush;
  return exit_code_of(design);
}

ExitCode run(const Options& options, Program& program) {
  if (options.base.file.empty() == options.study.empty())
    throw CommandFailed(ExitCode::invalid,
                        "give a CASE to begin, or --study ID to take a design up again");
  if (options.study.empty() && !options.flat)
    throw CommandFailed(ExitCode::invalid, "give the target for the cold slab: --flat");
  if (!options.plot.empty() && options.plot != "-") require_free(options.plot, options.force);
  Connection connection = program.connect();
  if (!options.study.empty())
    return wait_and_print(connection, options, resolve_study(connection, options.study));
  const v1::MouldPlan plan = plan_of(options);
  const auto study = create_study(connection, options.base, [&](v1::CreateStudyRequest& request) {
    *request.mutable_mould() = plan;
  });
  if (!study) return ExitCode::invalid;
  std::cerr << "study " << study->id() << "; taken up again by dccast design-mould --study "
            << study->id() << '\n';
  if (!options.no_wait) return wait_and_print(connection, options, study->id());
  std::cout << study->id() << std::endl;
  return ExitCode::done;
}

constexpr const char* examples =
    "dccast design-mould stationary-3d.toml --flat --wanted \"285 mm\"\n"
    "  dccast design-mould my.toml --flat --tolerance \"1 mm\" --set schedule.casting_speed=\"50 "
    "mm/min\"\n"
    "  dccast design-mould --study ID --plot mould.html   show an existing design, with a page of "
    "charts\n"
    "\n"
    "The first run casts in the mould of the case; each further one in an opening "
    "corrected\n"
    "by the deviation of the cold slab (docs/mould-design.md). Exit code 3 when no opening within "
    "the\n"
    "tolerance was found, or when the face that was found is not steady yet.";

void add_options(const cli::Command& command, Options& options) {
  command.option("CASE", options.base.file,
                 "Case file of a quarter slab that is cast until it is steady");
  command.flag("--flat", options.flat, "Find a cold slab that is flat along its wide face");
  command
      .option("--tolerance", options.tolerance,
              "Largest permitted deviation of the half-thickness of the cold slab along the face")
      .show_default();
  command.option("--wanted", options.wanted,
                 "Half-thickness of the cold slab; absent: the half-opening of the case's mould "
                 "at its narrow face");
  command.option("--runs", options.most_runs, "Largest number of runs; 0 for 12")
      .between(0, 50)
      .show_default();
  add_study_options(command, options,
                    {.study = "Take this design up again",
                     .plot = "Write an HTML page with mould and cold slab of the runs; - for "
                             "standard output",
                     .json = "As JSON, in metres, with every run"});
}

}  // namespace

void add_design_mould(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<Options>();
  const cli::Command command = line.command(
      "design-mould", "Find the mould opening of three segments that gives a flat cold slab",
      examples);
  add_options(command, *options);
  command.action([options, &program] { return run(*options, program); });
}

}  // namespace dccast::client::commands
