#include <iostream>

#include "client/case_faults.hpp"
#include "client/commands/commands.hpp"
#include "client/job_watch.hpp"
#include "client/message_json.hpp"
#include "client/refinement_study.hpp"
#include "client/render/curl_history.hpp"
#include "client/render/table.hpp"
#include "client/request_id.hpp"
#include "client/submission.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string file;
  int levels = 3;
  bool json = false;
};

/// One run of the study.
struct Level {
  int refinement = 1;
  std::string job;
  std::int64_t nodes = 0;
  double solver_s = 0.0;
  std::vector<double> curl_m;  ///< by monitor, at the end
};

/// The case with every cell and every time step divided.
v1::Case divided(const v1::Case& description, int parts) {
  v1::Case fine = description;
  case_file::apply_defaults(*fine.mutable_mesh());
  case_file::apply_defaults(*fine.mutable_time());
  fine.mutable_mesh()->set_refinement(fine.mesh().refinement() * parts);
  for (double& step : *fine.mutable_time()->mutable_step_s()->mutable_value()) step /= parts;
  return fine;
}

std::string submit(Connection& connection, const CaseUnderCheck& checked, int parts) {
  v1::SubmitJobRequest request;
  request.set_request_id(make_request_id());
  request.set_priority(v1::LOW);  // a study must not stand in the way of a question
  *request.mutable_case_() = divided(checked.description, parts);
  for (const v1::Attachment& attachment : checked.read.attachments)
    *request.add_attachments() = attachment;
  v1::Job job;
  const grpc::Status status = submit_patiently(connection, request, job);
  for (const v1::Fault& fault : faults_of(status))
    std::cerr << "refinement " << parts << ": " << describe(fault, checked.read.source) << '\n';
  check(status, connection.server());
  return job.id();
}

/// Waits for a run and takes its last step.
void collect(Connection& connection, Level& level, std::vector<std::string>& names) {
  const auto end = follow_job(connection, level.job, 1, [](const v1::JobEvent&) {}, std::cerr);
  if (end.state() != v1::SUCCEEDED) {
    throw CommandFailed(exit_code_of(end.state()), "refinement " + std::to_string(level.refinement) +
                                                       " (job " + level.job +
                                                       ") did not succeed: " + end.cause());
  }
  v1::QueryResultRequest request;
  request.set_id(level.job);
  const auto result = connection.call(&Stub::QueryResult, request);
  const v1::StepReport& last = result.steps(result.steps_size() - 1);
  level.nodes = last.nodes();
  level.solver_s = last.solver_s();
  names.clear();
  for (const v1::MonitorValue& monitor : last.monitors()) {
    names.push_back(monitor.name());
    level.curl_m.push_back(monitor.displacement_m(1));
  }
}

std::vector<double> figures_of(const std::vector<Level>& levels, std::size_t monitor) {
  std::vector<double> figures;
  for (const Level& level : levels) figures.push_back(level.curl_m[monitor]);
  return figures;
}

void print_table(const std::vector<Level>& levels, const std::vector<std::string>& names) {
  std::vector<std::string> headings{">refinement", ">nodes", ">solver s"};
  for (const std::string& name : names) headings.push_back(">" + name + " mm");
  render::Table table(headings);
  for (const Level& level : levels) {
    std::vector<std::string> row{std::to_string(level.refinement), std::to_string(level.nodes),
                                 render::fixed(level.solver_s, 1)};
    for (const double curl : level.curl_m) row.push_back(render::fixed(1e3 * curl, 3));
    table.add(std::move(row));
  }
  std::vector<std::string> order{"order", "", ""}, limit{"limit", "", ""}, error{"+-", "", ""};
  for (std::size_t m = 0; m < names.size(); ++m) {
    const Extrapolation e = extrapolate(figures_of(levels, m));
    order.push_back(e.order ? render::fixed(*e.order, 2) : "none");
    limit.push_back(render::fixed(1e3 * e.value, 3));
    error.push_back(render::fixed(1e3 * e.uncertainty, 3));
  }
  for (auto* row : {&order, &limit, &error}) table.add(std::move(*row));
  std::cout << table.text();
}

void print_json(const std::vector<Level>& levels, const std::vector<std::string>& names) {
  Json json{{"levels", Json::array()}, {"monitors", Json::array()}};
  for (const Level& level : levels)
    json["levels"].push_back({{"refinement", level.refinement},
                              {"job", level.job},
                              {"nodes", level.nodes},
                              {"solver_s", level.solver_s}});
  for (std::size_t m = 0; m < names.size(); ++m) {
    const std::vector<double> figures = figures_of(levels, m);
    const Extrapolation e = extrapolate(figures);
    json["monitors"].push_back({{"name", names[m]},
                                {"curl_m", figures},
                                {"order", e.order ? Json(*e.order) : Json(nullptr)},
                                {"limit_m", e.value},
                                {"uncertainty_m", e.uncertainty}});
  }
  std::cout << json.dump() << '\n';
}

ExitCode run(const Options& options, Program& program) {
  CaseUnderCheck checked = read_case(options.file);
  Connection connection = program.connect();
  if (checked.faults.empty()) check_with_server(checked, connection);
  if (!checked.faults.empty()) {
    print_faults(checked, std::cerr);
    return ExitCode::invalid;
  }
  std::vector<Level> levels;
  for (int k = 0; k < options.levels; ++k) {
    Level level;
    level.refinement = 1 << k;
    level.job = submit(connection, checked, level.refinement);
    std::cerr << "refinement " << level.refinement << ": job " << level.job << '\n';
    levels.push_back(std::move(level));
  }
  std::vector<std::string> names;
  for (Level& level : levels) collect(connection, level, names);
  options.json ? print_json(levels, names) : print_table(levels, names);
  return ExitCode::done;
}

}  // namespace

void add_convergence(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command = subcommand(
      app, "convergence",
      "How much of a curl is discretisation: runs the case with cells and steps halved again and "
      "again, and extrapolates the final curl of every monitor",
      "dccast convergence my.toml\n  dccast convergence --levels 2 --json my.toml");
  command->add_option("FILE", options->file, "Case file")->required();
  command
      ->add_option("--levels", options->levels,
                   "Runs, each with half the cell and step of the one before; an order needs three")
      ->check(CLI::Range(2, 5))
      ->capture_default_str();
  command->add_flag("--json", options->json, "As JSON, in metres");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
