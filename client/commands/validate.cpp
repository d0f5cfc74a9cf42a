#include <iostream>

#include "client/case_faults.hpp"
#include "client/case_options.hpp"
#include "client/commands/commands.hpp"
#include "client/render/findings.hpp"
#include "client/render/progress.hpp"

namespace dccast::client::commands {
namespace {

struct Options {
  std::string file;
  std::vector<std::string> set;
  bool local = false;
  bool json = false;
  bool strict = false;
};

void print_verdict(const CaseUnderCheck& checked, bool local) {
  if (!checked.faults.empty())
    std::cerr << checked.faults.size() << (checked.faults.size() == 1 ? " fault\n" : " faults\n");
  else if (checked.estimate)
    std::cout << "sound: " << checked.estimate->nodes() << " nodes, "
              << checked.estimate->elements() << " elements, " << checked.estimate->steps()
              << " steps, about " << render::duration_text(checked.estimate->solver_s())
              << " of computing\n";
  else
    std::cout << (local ? "no faults found without a server\n" : "sound\n");
}

ExitCode run(const Options& options, Program& program) {
  CaseUnderCheck checked = read_case(options.file, changes_of(options.set));
  if (!options.local) {
    Connection connection = program.connect();
    check_with_server(checked, connection);
  }
  if (options.json) {
    std::cout << faults_json(checked).dump() << '\n';
  } else {
    print_faults(checked, std::cout);
    for (const v1::Finding& finding : checked.findings)
      std::cout << render::finding_line(finding) << '\n';
    print_verdict(checked, options.local);
  }
  const bool implausible = options.strict && render::more_than_notes(checked.findings);
  return checked.faults.empty() && !implausible ? ExitCode::done : ExitCode::invalid;
}

}  // namespace

void add_validate(CLI::App& app, Program& program) {
  auto options = make_options<Options>();
  CLI::App* const command =
      subcommand(app, "validate",
                 "Check a case file: list everything that is wrong with it, and findings on "
                 "whether a plant could cast it",
                 "dccast validate my.toml\n  dccast validate --set mesh.rows=30 my.toml");
  command->add_option("FILE", options->file, "Case file; - for standard input")->required();
  add_set_option(*command, options->set);
  command->add_flag("--local", options->local,
                    "Do not ask the server: check keys, units and ranges only");
  command->add_flag("--strict", options->strict,
                    "Exit code 2 for findings beyond notes too (docs/findings.md)");
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &program] {
    program.action = [options, &program] { return run(*options, program); };
  });
}

}  // namespace dccast::client::commands
