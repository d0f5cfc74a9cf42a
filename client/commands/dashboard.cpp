#include <unistd.h>

#include <cstdlib>
#include <iostream>

#include "client/commands/commands.hpp"
#include "client/web/dashboard.hpp"

namespace dccast::client::commands {
namespace {

struct DashboardOptions {
  std::vector<std::string> cases;
  int port = 0;
  bool open = false;
};

/// Shows an address in the user's browser, which outlives this program.
void open_in_browser(const std::string& address) {
  const pid_t child = ::fork();
  if (child != 0) return;
  ::setsid();
  ::execlp("xdg-open", "xdg-open", address.c_str(), nullptr);
  std::_Exit(127);
}

ExitCode run(const DashboardOptions& options, Program& program) {
  for (const std::string& file : options.cases)
    if (::access(file.c_str(), R_OK) != 0)
      throw CommandFailed(ExitCode::invalid, file + ": cannot be read; give a case file");
  web::WebServer server(options.port);
  web::add_dashboard(
      server,
      [&program](std::shared_ptr<Interruption> gone) {
        return Connection(program.endpoint(), std::move(gone));
      },
      options.cases);
  const std::string address = server.address();
  std::cout << address << std::endl;
  std::cerr << "This address opens the dashboard once, on this machine. Ctrl-C ends it.\n";
  if (options.open) open_in_browser(address);
  server.serve(*program.interruption);
  return ExitCode::done;
}

}  // namespace

void add_dashboard(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<DashboardOptions>();
  const cli::Command command = line.command(
      "dashboard",
      "Show queue, results and what-if in a browser: a web server on the loopback address, for you "
      "alone, until Ctrl-C",
      "dccast dashboard --open\n  dccast dashboard my.toml    what-if begins with this case");
  command.option("FILE", options->cases, "Case files that a what-if can begin with");
  command.option("--port", options->port, "Port on 127.0.0.1; by default a free one")
      .between(1, 65535);
  command.flag("--open", options->open, "Open the page in your browser");
  command.action([options, &program] { return run(*options, program); });
}

}  // namespace dccast::client::commands
