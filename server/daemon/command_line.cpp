#include "server/daemon/command_line.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

namespace dccast::daemon {

CommandLine read_command_line(int argc, char** argv) {
  CommandLine line;
  CLI::App app(
      "dccastd: simulation service for DC-cast slabs. Takes jobs over gRPC, runs each in a "
      "worker process, keeps events and results.",
      "dccastd");
  app.add_option("--config", line.config_file,
                 "Settings, TOML; every key has a default, see deploy/config/dccastd.toml");
  app.add_option("--set", line.overrides,
                 "One setting over the file's, e.g. --set listen=127.0.0.1:0; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.set_version_flag("--version", "dccastd " DCCAST_VERSION);
  app.footer(
      "Example: dccastd --config deploy/config/dccastd.toml --set workers=2\n"
      "SIGTERM and SIGINT stop running jobs at a checkpoint; the next start goes on with them.\n"
      "Exit codes: 0 stopped as asked; 2 usage or invalid settings; 4 the address or the data "
      "directory cannot be used.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    line.exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
  }
  return line;
}

}  // namespace dccast::daemon
