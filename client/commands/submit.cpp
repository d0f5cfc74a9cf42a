#include <iostream>
#include <map>

#include "client/case_faults.hpp"
#include "client/commands/commands.hpp"
#include "client/submission.hpp"
#include "proto/values/shortened.hpp"
#include "proto/values/uuid.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string file;
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

ExitCode run(const Options& options, Program& program) {
  CaseUnderCheck checked = read_case(options.file);
  Connection connection = program.connect();
  check_with_server(checked, connection);
  if (!checked.faults.empty()) return refuse(checked, options.json);
  for (const v1::Fault& warning : checked.warnings)
    std::cerr << "warning: " << describe(warning, checked.read.source) << '\n';

  v1::SubmitJobRequest request;
  request.set_request_id(options.request_id.empty() ? values::random_uuid() : options.request_id);
  request.set_priority(options.priority);
  *request.mutable_case_() = checked.description;
  for (v1::Attachment& attachment : checked.read.attachments)
    request.add_attachments()->Swap(&attachment);
  v1::Job job;
  const grpc::Status status = submit_patiently(connection, request, job);
  checked.faults = faults_of(status);
  if (!checked.faults.empty()) return refuse(checked, options.json);
  check(status, connection.server());

  if (options.json)
    std::cout << to_json(job).dump() << std::endl;
  else
    std::cout << job.id() << std::endl;
  if (!options.watch) return ExitCode::done;
  return watch_job(connection, job.id(), 1, options.json, true, options.strict);
}

}  // namespace

void add_submit(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "submit", "Queue a case; prints the job's id",
                 "dccast submit my.toml\n  dccast submit --watch --priority high my.toml");
  command->add_option("FILE", options->file, "Case file")->required();
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
                    "Job as JSON, with --watch followed by one event a line");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
