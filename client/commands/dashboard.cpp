#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <optional>

#include "client/commands/commands.hpp"
#include "client/model/json.hpp"
#include "client/session/socket.hpp"
#include "client/web/dashboard.hpp"
#include "client/web/redirect_file.hpp"
#include "proto/values/address.hpp"

namespace dccast::client {
namespace {

struct DashboardOptions {
  std::vector<std::string> cases;
  int port = 0;
  std::string listen, certificate, key;
  bool open = false;
};

/// All users of a dashboard that is open to other machines share its login, so that login may only
/// read.
void require_viewer(Program& program) {
  Connection connection = program.connect();
  const auto user = connection.call(&Stub::WhoAmI, v1::WhoAmIRequest());
  if (user.role() != v1::VIEWER)
    throw invalid("--listen: those who open the page would act as " + user.name() +
                  ", who may do more than look; log in as a viewer (on the server: dccastd user "
                  "add wall --role viewer)");
}

Listening listening_of(const DashboardOptions& options, Program& program) {
  if (options.listen.empty()) return {.port = options.port};
  if (options.certificate.empty() || options.key.empty())
    throw invalid("--listen " + options.listen +
                  ": others are served by HTTPS alone; give --certificate and --key, PEM files of "
                  "a certificate for this name");
  // Whoever opens the page acts with this login: it must not be able to change anything.
  require_viewer(program);
  const values::HostAndPort at = values::host_and_port(options.listen);
  if (at.port.size() > 5 || at.port.find_first_not_of("0123456789") != std::string::npos ||
      std::atoi(at.port.c_str()) > 65535)
    throw invalid("--listen " + options.listen +
                  ": the port is not 1 to 65535; without one, a free one is taken");
  return {.host = at.host,
          .port = at.port.empty() ? options.port : std::atoi(at.port.c_str()),
          .certificate = options.certificate,
          .key = options.key};
}

/// The name by which others reach an address of this machine.
std::string name_of(const std::string& host) {
  return host == "0.0.0.0" || host == "::" ? host_name() : host;
}

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
  const Listening listening = listening_of(options, program);
  WebServer server(listening);
  KeyEntrance entrance(name_of(listening.host), server.port(), server.certificate());
  if (!entrance.knows_itself())
    throw invalid(
        fmt::format("--certificate {}: is not for {}; give --listen a name that stands "
                    "in it",
                    listening.certificate, name_of(listening.host)));

  const Connection connection(program.endpoint());
  add_dashboard(
      server, [&](const Request&) { return connection.another(std::make_shared<Interruption>()); },
      options.cases);
  server.post("/another", [&](const Request&) {
    return Reply{Json{{"address", entrance.address()}}.dump()};
  });
  const std::string address = entrance.address();
  std::cout << address << std::endl;
  std::cerr << "This address opens the dashboard once"
            << (options.listen.empty() ? ", on this machine" : "") << ". Ctrl-C ends it.\n";

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
      "dccast dashboard --open\n  dccast dashboard my.toml    what-if begins with this case\n"
      "  dccast --server viewer dashboard --listen desk7:7300 --certificate d.pem --key d.key");
  command.option("FILE", options.cases, "Case files that a what-if can begin with");
  command.option("--port", options.port, "Port on 127.0.0.1; by default a free one",
                 {.between = {{1, 65535}}});
  command.option("--listen", options.listen,
                 "HOST[:PORT], a name or address of this machine: serve others, too. HTTPS, and "
                 "the login must be a viewer's");
  command.option("--certificate", options.certificate, "PEM file for --listen, with its chain");
  command.option("--key", options.key, "PEM file with the certificate's key");
  command.flag("--open", options.open, "Open the page in your browser");
}

}  // namespace dccast::client
