#include <iostream>
#include <map>

#include "client/case_faults.hpp"
#include "client/case_options.hpp"
#include "client/commands/commands.hpp"
#include "client/submission.hpp"
#include "proto/values/shortened.hpp"
#include "proto/values/uuid.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::vector<std::string> files;
  std::vector<std::string> set;
  std::vector<std::string> labels;
  std::string request_id;
  v1::Priority priority = v1::NORMAL;
  bool watch = false;
  bool json = false;
  bool strict = false;
};

ExitCode refuse(const CaseUnderCheck& checked, bool json) {
  if (json) std::cout << faults_json(checked).dump() << '\n';
  print_faults(checked, std::cerr);
  std::cerr << "dccast: not submitted, " << checked.faults.size()
            << (checked.faults.size() == 1 ? " fault\n" : " faults\n");
  return ExitCode::invalid;
}

void require_one_file(const Options& options) {
  const char* const what = !options.request_id.empty() ? "--request-id" : "--watch";
  if (options.files.size() == 1 || (options.request_id.empty() && !options.watch)) return;
  throw CommandFailed(ExitCode::invalid, std::string(what) + " goes with one FILE; " +
                                             std::to_string(options.files.size()) + " are given");
}

/// Checks all cases: if one has faults, none is submitted.
/// @return  empty if one has faults, which have then been printed
std::optional<std::vector<CaseUnderCheck>> examined_cases(const Options& options,
                                                          Connection& connection) {
  std::vector<CaseUnderCheck> cases;
  bool sound = true;
  for (const std::string& file : options.files) {
    CaseUnderCheck& checked = cases.emplace_back(read_case(file, changes_of(options.set)));
    check_with_server(checked, connection);
    if (!checked.faults.empty()) refuse(checked, options.json);
    sound = sound && checked.faults.empty();
  }
  if (!sound) return std::nullopt;
  for (const CaseUnderCheck& checked : cases)
    for (const v1::Fault& warning : checked.warnings)
      std::cerr << "warning: " << describe(warning, checked.read.source) << '\n';
  return cases;
}

v1::SubmitJobRequest request_of(CaseUnderCheck& checked, const Options& options) {
  v1::SubmitJobRequest request;
  request.set_request_id(options.request_id.empty() ? values::random_uuid() : options.request_id);
  request.set_priority(options.priority);
  *request.mutable_case_() = checked.description;
  request.mutable_labels()->Assign(options.labels.begin(), options.labels.end());
  request.mutable_changes()->Assign(checked.changes.begin(), checked.changes.end());
  for (v1::Attachment& attachment : checked.read.attachments)
    request.add_attachments()->Swap(&attachment);
  return request;
}

/// @return  empty if the server has found further faults, which have then been printed
std::optional<v1::Job> submit(CaseUnderCheck& checked, const Options& options,
                              Connection& connection) {
  const v1::SubmitJobRequest request = request_of(checked, options);
  v1::Job job;
  const grpc::Status status = submit_patiently(connection, request, job);
  checked.faults = faults_of(status);
  if (!checked.faults.empty()) {
    refuse(checked, options.json);
    return std::nullopt;
  }
  check(status, connection.server());
  std::cout << (options.json ? to_json(job).dump() : job.id()) << std::endl;
  return job;
}

ExitCode run(const Options& options, Program& program) {
  require_one_file(options);
  Connection connection = program.connect();
  auto cases = examined_cases(options, connection);
  if (!cases) return ExitCode::invalid;
  for (CaseUnderCheck& checked : *cases) {
    const auto job = submit(checked, options, connection);
    if (!job) return ExitCode::invalid;
    if (options.watch)
      return watch_job(connection, job->id(), 1, options.json, true, options.strict);
  }
  return ExitCode::done;
}

constexpr const char* examples =
    "dccast submit my.toml\n"
    "  dccast submit --watch --priority high my.toml\n"
    "  dccast submit --set mesh.rows=30 --set schedule.water_flow.scale=\"0.8 until 100 mm\" "
    "my.toml\n"
    "  dccast submit --label trial-7 casts/*.toml\n"
    "  sed s/680/690/ my.toml | dccast submit -\n"
    "\n"
    "Of several files all are checked before the first is submitted; one id a line.";

}  // namespace

void add_submit(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "submit", "Queue cases; prints the id of each job", examples);
  command->add_option("FILE", options->files, "Case files; - for standard input")->required();
  add_set_option(*command, options->set);
  command->add_option("--label", options->labels, "Label for finding the job; repeatable")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_flag("-w,--watch", options->watch,
                    "Follow the job to its end; exit code 3 if it does not succeed");
  command
      ->add_flag("--strict", options->strict,
                 "With --watch: exit code 3 for a job with findings beyond notes too")
      ->needs("--watch");
  const std::map<std::string, v1::Priority> priorities{
      {"low", v1::LOW}, {"normal", v1::NORMAL}, {"high", v1::HIGH}};
  command
      ->add_option("-p,--priority", options->priority,
                   "Place in the queue: low, normal (default) or high")
      ->transform(CLI::CheckedTransformer(priorities, CLI::ignore_case).description(""))
      ->type_name("PRIORITY");
  command
      ->add_option(
          "--request-id", options->request_id,
          "Submitting again with the same id gives the same job; by default a new one is made")
      ->check([](const std::string& text) { return values::too_long("the request id", text); });
  command->add_flag("--json", options->json,
                    "Each job as JSON on a line, with --watch followed by one event a line");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
