// dccast-web: the pages and the JSON of the dashboard for all users of a daemon of this machine. It
// is a client of the daemon without rights of its own: each call carries the token of its user.
#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>
#include <unistd.h>

#include <cstdlib>
#include <ctime>
#include <iostream>
#include <optional>

#include "client/cli/options.hpp"
#include "client/model/json.hpp"
#include "client/web/connect_messages.hpp"
#include "client/web/dashboard.hpp"
#include "client/web/session_entrance.hpp"
#include "client/web/user_channels.hpp"
#include "proto/values/address.hpp"
#include "proto/values/local_socket.hpp"

namespace dccast::client {
namespace {

struct WebOptions {
  std::string listen, certificate, key, proxy, socket, state;
};

constexpr const char* default_state = "/var/lib/dccast-web";

std::filesystem::path key_file(const WebOptions& options) {
  const char* const folder = std::getenv("STATE_DIRECTORY");  // of systemd
  if (!options.state.empty()) return options.state + "/cookie-keys";
  return std::string(folder == nullptr ? default_state : folder) + "/cookie-keys";
}

http::Server::Listening listening_of(const WebOptions& options) {
  const bool is_behind = !options.proxy.empty();
  const bool is_socket = options.listen.starts_with(values::unix_scheme);
  if (is_behind == !options.certificate.empty() ||
      options.certificate.empty() != options.key.empty())
    throw invalid(
        "give --certificate and --key, PEM files, or --behind with the address that the proxy has");
  if (is_behind && !values::is_web_origin(options.proxy))
    throw invalid("--behind " + options.proxy + ": is not https://NAME or https://NAME:PORT");
  if (is_socket && !is_behind)
    throw invalid("--listen " + options.listen +
                  ": only a proxy calls a Unix socket; add --behind with its address");
  if (is_socket) return {.socket = options.listen.substr(std::string(values::unix_scheme).size())};

  if (is_behind && !values::is_loopback(options.listen))
    throw invalid(
        "--listen " + options.listen +
        ": behind a proxy, unix:PATH, 127.0.0.1:PORT or [::1]:PORT; others would reach it "
        "without HTTPS");
  const auto port = values::port_of(options.listen);
  if (!port)
    throw invalid(
        "--listen " + options.listen +
        ": give HOST:PORT, with a port of 0 to 65535, where 0 is a free one, or unix:PATH");
  const std::string host = values::host_and_port(options.listen).host;
  const auto report = [certificate = options.certificate](const std::string& fault) {
    std::cerr << "dccast-web: --certificate " << certificate
              << (fault.empty()
                      ? " has changed and is in use"
                      : " has changed and is not used: it and --key are not a certificate "
                        "and its key; the former one stays")
              << std::endl;
  };
  return {.host = host.empty() ? "0.0.0.0" : host,
          .port = *port,
          .certificate = options.certificate,
          .key = options.key,
          .when_renewed = report};
}

/// The secret in what a user has pasted: a line, a link, or the secret alone.
std::string secret_in(const std::string& text) {
  const auto at = text.find("dccast-enrol-");
  if (at == std::string::npos)
    throw invalid("this is no line or link of `dccastd user line`; ask your administrator for one");
  const auto end = text.find_first_not_of("0123456789abcdefghijklmnopqrstuvwxyz-", at);
  return text.substr(at, end - at);
}

/// Exchanges a line for a token of a session, named "web".
Reply sign_in(UserChannels& channels, const SessionCookie& cookie, const Request& request) {
  v1::EnrolRequest enrol;
  if (!google::protobuf::util::JsonStringToMessage(request.body, &enrol).ok())
    throw invalid(R"(send {"secret": "LINE"} as JSON)");
  enrol.set_secret(secret_in(enrol.secret()));
  enrol.set_machine("web");
  Connection connection = channels.connection("", request.address);
  v1::EnrolResponse response;
  check(connection.try_once(&Stub::Enrol, enrol, response), connection.server());

  const std::int64_t now = std::time(nullptr);
  Reply reply = json_reply(Json{{"user", response.user().name()}}.dump());
  reply.headers = {
      {"Set-Cookie", cookie.set({.token = response.token(), .begun_unix = now, .seen_unix = now})}};
  return reply;
}

/// Revokes the token of a session. The browser forgets it in any case.
Reply sign_out(Connection connection, const SessionCookie& cookie) {
  v1::RevokeTokenResponse response;
  const grpc::Status status =
      connection.try_once(&Stub::RevokeToken, v1::RevokeTokenRequest(), response);
  const bool is_revoked = status.ok() || status.error_code() == grpc::UNAUTHENTICATED;
  Reply reply = is_revoked ? json_reply("{}") : error_reply(status, connection.server());
  reply.headers = {{"Set-Cookie", cookie.removal()}};
  return reply;
}

ExitCode serve(const WebOptions& options, const std::shared_ptr<Interruption>& interruption) {
  const http::Server::Listening listening = listening_of(options);
  const bool is_behind = !options.proxy.empty();
  WebServer server(listening, is_behind);
  SessionEntrance entrance(SessionCookie(cookie_keys(key_file(options), false)), options.proxy,
                           is_behind ? nullptr : &server.server());
  UserChannels channels(options.socket.empty()
                            ? std::string(values::unix_scheme) + values::service_socket
                            : options.socket);

  add_dashboard(
      server,
      [&](const Request& request) { return channels.connection(request.token, request.address); },
      {});
  server.post("/session/*", [&](const Request& request) {
    if (request.name == "in") return sign_in(channels, entrance.cookie(), request);
    if (request.name == "out")
      return sign_out(channels.connection(request.token, request.address), entrance.cookie());
    return Reply{.status = 404};
  });

  const std::string place = listening.socket.empty()
                                ? fmt::format("{}, port {}", listening.host, server.server().port())
                                : options.listen;
  std::cerr << "dccast-web: serving at " << place << std::endl;
  server.serve(entrance, *interruption);
  return ExitCode::done;
}

const char* const guide =
    "\nUsers sign in with a link or line of `dccastd user line NAME`. The daemon must know the "
    "user\n"
    "of this program: access.web_user in its settings. See /usr/share/doc/dccastd/pages/web.md.\n";

int run(const std::vector<std::string>& arguments,
        const std::shared_ptr<Interruption>& interruption) {
  CommandLine line("dccast-web", "Serve the pages and the JSON of dccast to all users of a server",
                   DCCAST_VERSION, guide);
  WebOptions options;
  line.begin_group("Commands to serve browsers");
  const Command server =
      line.command("serve", "Serve browsers and programs until SIGTERM",
                   "dccast-web serve --listen :443 --certificate web.pem --key web.key\n"
                   "  dccast-web serve --listen unix:/run/dccast-web/socket --behind "
                   "https://dccast.plant.example");
  server.option("--listen", options.listen,
                "HOST:PORT; without a host, all addresses. unix:PATH for a proxy of this machine",
                {.required = true});
  server.option(
      "--certificate", options.certificate,
      "PEM file of the certificate with its chain, for HTTPS; read again when it changes");
  server.option("--key", options.key, "PEM file with the certificate's key");
  server.option("--behind", options.proxy,
                "Address of the proxy that serves this program to others, https://NAME[:PORT]");
  server.option("--socket", options.socket,
                "unix:PATH of the daemon's socket; by default that of the installed service");
  const Command key = line.command(
      "exchange-key",
      "Make a new key for the cookies. The former one still opens them after the next start; "
      "twice, and all users sign in again",
      "dccast-web exchange-key && systemctl restart dccast-web");
  for (const Command& command : {server, key})
    command.option("--state", options.state,
                   "Folder with the keys of the cookies; by default /var/lib/dccast-web");
  server.action([&] { return serve(options, interruption); });
  key.action([&] {
    cookie_keys(key_file(options), true);
    return ExitCode::done;
  });

  try {
    return static_cast<int>(line.run(arguments));
  } catch (const CommandFailed& failure) {
    std::cerr << "dccast-web: " << failure.what() << '\n';
    return static_cast<int>(failure.code());
  } catch (const std::exception& error) {
    std::cerr << "dccast-web: " << error.what() << '\n';
    return static_cast<int>(ExitCode::invalid);
  }
}

}  // namespace
}  // namespace dccast::client

int main(int argc, char** argv) {
  // gRPC writes developer messages to standard error.
  ::setenv("GRPC_VERBOSITY", "NONE", 0);
  const auto interruption = std::make_shared<dccast::client::Interruption>();
  dccast::client::interrupt_by_signals(interruption);
  const int code = dccast::client::run({argv + 1, argv + argc}, interruption);
  interruption->end_command(code);
  return code;
}
