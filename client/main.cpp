#include <unistd.h>

#include <cstdlib>
#include <iostream>

#include "client/commands/commands.hpp"
#include "client/text/terminal_guard.hpp"

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
  const int code = dccast::client::run_command_line({argv + 1, argv + argc}, program);
  program.interruption->end_command(code);
  return code;
}
