#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <optional>

#include "client/commands/commands.hpp"
#include "client/web/dashboard.hpp"
#include "client/web/redirect_file.hpp"

namespace dccast::client {
namespace {

struct DashboardOptions {
  std::vector<std::string> cases;
  int port = 0;
  bool open = false;
};

/// Opens a file in the user's browser, which outlives this program.
void open_in_browser(const std::string& path) {
  const pid_t child = ::fork();
  if (child != 0) return;
  ::setsid();
  ::execlp("xdg-open", "xdg-open", path.c_str(), nullptr);
  std::_Exit(127);
}

ExitCode run(const DashboardOptions& options, Program& program) {
  for (const std::string& file : options.cases)
    if (::access(file.c_str(), R_OK) != 0)
      throw invalid(file + ": cannot be read; give a case file");
  WebServer server({.host = "127.0.0.1", .port = options.port});
  KeyEntrance entrance(server.server().port());
  const Connection connection(program.endpoint());
  add_dashboard(
      server, [&](const Request&) { return connection.another(std::make_shared<Interruption>()); },
      options.cases);
  const std::string address = entrance.address();
  std::cout << address << std::endl;
  std::cerr << "This address opens the dashboard once, on this machine. Ctrl-C ends it.\n";

  std::optional<RedirectFile> redirect;
  if (options.open) {
    redirect.emplace(address);
    // The address works once, and lies in a file no longer than that.
    entrance.when_entered([&redirect] { redirect->remove(); });
    open_in_browser(redirect->path());
  }
  server.serve(entrance, *program.interruption);
  return ExitCode::done;
}

}  // namespace

void add_dashboard(CommandLine& line, Program& program) {
  const auto [command, options] = declare<DashboardOptions>(
      line, program, run, "dashboard",
      "Show queue, results and what-if in a browser: a web server on the loopback address, for you "
      "alone, until Ctrl-C",
      "dccast dashboard --open\n  dccast dashboard my.toml    what-if begins with this case");
  command.option("FILE", options.cases, "Case files that a what-if can begin with");
  command.option("--port", options.port, "Port on 127.0.0.1; by default a free one",
                 {.between = {{1, 65535}}});
  command.flag("--open", options.open, "Open the page in your browser");
}

}  // namespace dccast::client
