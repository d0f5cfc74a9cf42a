#include "client/query.hpp"

#include <unistd.h>

#include <iostream>

#include "client/case_options.hpp"
#include "client/commands/commands.hpp"
#include "client/job_watch.hpp"
#include "client/render/answer_text.hpp"
#include "client/render/progress.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string file;
  std::vector<std::string> set;
  bool keep = false;
  bool json = false;
};

ExitCode refuse(const CaseUnderCheck& checked, bool json) {
  if (json) std::cout << faults_json(checked).dump() << '\n';
  print_faults(checked, std::cerr);
  return ExitCode::invalid;
}

/// The curve as it is computed, on a terminal; the answer as a whole is printed at its end.
std::optional<Answer> ask(Connection& connection, CaseUnderCheck& checked, const Options& options) {
  const render::Terminal terminal = render::terminal_of(STDOUT_FILENO);
  if (options.json || !terminal.interactive) return ask_query(connection, checked, options.keep);
  render::Progress progress(std::cout, terminal);
  auto answer = ask_query(connection, checked, options.keep, [&](const auto& response) {
    if (!response.has_step()) return;
    v1::JobEvent event;
    *event.mutable_step() = response.step();
    progress.show(event);
  });
  progress.finish();
  return answer;
}

ExitCode run(const Options& options, Program& program) {
  CaseUnderCheck checked = read_case(options.file, changes_of(options.set));
  if (!checked.faults.empty()) return refuse(checked, options.json);
  Connection connection = program.connect();
  auto answer = ask(connection, checked, options);
  if (!answer) return refuse(checked, options.json);
  answer->name = checked.read.source.file();
  std::cout << (options.json ? render::answer_json(*answer).dump() + "\n"
                             : render::answer_text(*answer))
            << std::flush;
  std::cerr << render::origin_text(*answer) << '\n';
  return exit_code_of(answer->state);
}

constexpr const char* examples =
    "dccast query my.toml\n"
    "  dccast query my.toml --set schedule.casting_speed=\"70 mm/min\" "
    "--set schedule.water_flow.scale=\"0.8 until 100 mm\"\n"
    "  dccast query --json my.toml | jq '.monitors[] | {name, end_curl_m}'\n"
    "\n"
    "Runs at once, beside the queue. Ctrl-C ends the run. A case that was computed before, by a "
    "job\n"
    "or a query, is answered from the store.";

}  // namespace

void add_query(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "query", "Compute the curl of a case at once, without a job", examples);
  command->add_option("FILE", options->file, "Case file; - for standard input")->required();
  add_set_option(*command, options->set);
  command->add_flag("--keep", options->keep, "Keep the run as a job, with its results");
  command->add_flag("--json", options->json, "As JSON, in metres and seconds, with the history");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
