#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include "client/commands/commands.hpp"
#include "client/text/terminal_guard.hpp"

namespace {

/// Every user of the machine can read the arguments of a process: the secret in the line of a login
/// is overwritten as soon as it was read.
void hide_secrets(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument.find("dccast-enrol-") != std::string_view::npos)
      std::fill_n(argv[i], argument.size(), '*');
  }
}

}  // namespace

int main(int argc, char** argv) {
  // gRPC writes developer messages to standard error; the commands report errors themselves.
  ::setenv("GRPC_VERBOSITY", "NONE", 0);
  const dccast::client::TerminalGuard output(std::cout, STDOUT_FILENO);
  const dccast::client::TerminalGuard messages(std::cerr, STDERR_FILENO);

  dccast::client::Program program;
  program.configuration = dccast::client::configuration_file();
  if (!program.configuration.empty())
    program.servers = program.configuration.parent_path() / "servers.toml";
  dccast::client::interrupt_by_signals(program.interruption);
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  hide_secrets(argc, argv);
  const int code = dccast::client::run_command_line(arguments, program);
  program.interruption->end_command(code);
  return code;
}
