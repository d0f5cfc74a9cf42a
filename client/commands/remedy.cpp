#include <iostream>

#include "client/cli/common_options.hpp"
#include "client/commands/commands.hpp"
#include "client/session/jobs.hpp"
#include "client/session/plan_requests.hpp"
#include "client/session/studies.hpp"

namespace dccast::client {
namespace {

struct RemedyOptions : StudyOptions {
  std::string job, point, line;
};

ExitCode run(const RemedyOptions& options, Program& program) {
  require_free(options.plot, options.force);
  Connection connection = program.connect();
  const std::string job = resolve_job(connection, options.job);
  const std::string come_back =
      "dccast remedy " + job + (options.line.empty() ? "" : " --line " + options.line);

  const v1::Study study = remedy_of(connection, job, options.line);
  std::cerr << "study " << study.id() << ", " << study.runs() << " runs; taken up again by "
            << come_back << '\n';
  if (options.no_wait) {
    std::cout << study.id() << std::endl;
    return ExitCode::done;
  }

  follow_with_progress(connection, study.id(), come_back);
  const auto answer = judge_study(connection, {.id = study.id(), .monitor = options.point});
  print_answer(options, answer);
  return exit_code_of(answer, answer.study().succeeded() > 0);
}

}  // namespace

void add_remedy(CommandLine& line, Program& program) {
  const auto [command, options] = declare<RemedyOptions>(
      line, program, run, "remedy",
      "What helps against the findings of a job: which lever of the plant, and how far",
      "dccast remedy last\n"
      "  dccast remedy JOB --plot remedy.html\n"
      "\n"
      "Three drafts for each lever that influences a finding, compared at equal cast length. A "
      "lever\n"
      "is named where its effect is larger than its error (docs/findings.md).");
  command.option("JOB", options.job, job_help, required);
  command.option("--point", options.point, "Monitor; absent: output.curl, or the largest curl");
  command.option("--line", options.line,
                 "Drafts of a casting that this line leaves possible (dccast line add)");
  command.flag("--no-wait", options.no_wait, "Do not wait for the drafts to end");
  command.option("--plot", options.plot, "Write an HTML page; - for standard output");
  add_force_flag(command, options.force);
  command.json(options.json, "As JSON, in SI units");
}

}  // namespace dccast::client
