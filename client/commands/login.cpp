#include <cstdlib>
#include <iostream>

#include "client/commands/commands.hpp"
#include "client/session/servers.hpp"
#include "proto/values/address.hpp"
#include "proto/values/local_socket.hpp"

namespace dccast::client {
namespace {

struct LoginOptions {
  std::vector<std::string> words;
  std::string name;
  bool first = false;
  bool renew = false;
};

/// The line from the arguments or standard input. A separate address replaces that of the line.
EnrolmentLine line_of(const std::vector<std::string>& words) {
  std::string text, address;
  for (const std::string& word : words)
    (word.find('/') == std::string::npos ? address : text) = word;
  if (text.empty()) {
    std::cerr << "Line of `dccastd user add`: ";
    std::getline(std::cin, text);
  }
  EnrolmentLine line = read_enrolment_line(text);
  if (!address.empty()) line.address = address;
  return line;
}

/// The new token is on the disk before the old one is revoked.
ExitCode renew(Program& program) {
  StoredServers servers(program.servers);
  const StoredServer* found = servers.find(program.server);
  if (found == nullptr || found->endpoint.token.empty())
    throw CommandFailed(ExitCode::not_found,
                        "there is no login with a token" +
                            (program.server.empty() ? "" : " for " + program.server));

  const StoredServer old = *found;
  StoredServer server = old;
  renew_token(server, program.interruption);
  servers.store(server, servers.all().front().name == server.name);

  Connection connection(old.endpoint, program.interruption);
  v1::RevokeTokenResponse response;
  connection.try_once(&Stub::RevokeToken, v1::RevokeTokenRequest(), response);
  std::cerr << "the token for " << server.name << " is good until "
            << utc_text(std::atoll(server.expires.c_str())) << '\n';
  return ExitCode::done;
}

ExitCode run(const LoginOptions& options, Program& program) {
  if (options.renew) return renew(program);
  const EnrolmentLine line = line_of(options.words);
  StoredServers servers(program.servers);
  const std::string name =
      options.name.empty() ? values::host_and_port(line.address).host : options.name;
  const StoredServer server = log_in(line, name, program.interruption);
  servers.store(server,
                options.first || servers.all().empty() || servers.all().front().name == name);
  std::cerr << "logged in to " << server.endpoint.address << " as " << server.user << "; --server "
            << name << (servers.all().front().name == name ? " is the default" : "") << '\n';
  return ExitCode::done;
}

ExitCode log_out(Program& program) {
  StoredServers servers(program.servers);
  const StoredServer* server = servers.find(program.server);
  if (server == nullptr)
    throw CommandFailed(ExitCode::not_found, std::string("there is no login") +
                                                 (program.server.empty() ? "" : " for ") +
                                                 program.server + "; nothing was changed");
  const std::string name = server->name;
  Connection connection(server->endpoint, program.interruption);
  v1::RevokeTokenResponse response;
  const grpc::Status status =
      connection.try_once(&Stub::RevokeToken, v1::RevokeTokenRequest(), response);
  // Forgotten here in any case: a server that is gone would keep the user logged in.
  servers.remove(name);
  std::cerr << "logged out of " << name << '\n';
  if (!status.ok())
    std::cerr << "the server could not revoke the token (" << reason_of(status)
              << "); an admin can: dccastd user rotate\n";
  return ExitCode::done;
}

struct WhoAmIOptions {
  bool json = false;
};

ExitCode run(const WhoAmIOptions& options, Program& program) {
  Connection connection = program.connect();
  const auto user = connection.call(&Stub::WhoAmI, v1::WhoAmIRequest());

  if (options.json) {
    print_line({{"server", connection.server()},
                {"name", user.name()},
                {"role", role_text(user.role())},
                {"proof", user.proof()},
                {"expires",
                 user.has_expire_time() ? Json(utc_text(user.expire_time().seconds())) : Json()}});
    return ExitCode::done;
  }

  std::cout << user.name() << " on " << connection.server() << ", " << role_text(user.role())
            << ", by " << user.proof();
  if (user.has_expire_time()) std::cout << " until " << utc_text(user.expire_time().seconds());
  std::cout << '\n';

  const StoredServers stored(program.servers);
  for (const StoredServer& server : stored.all())
    std::cerr << "login  " << server.name << "  " << server.endpoint.address << "  " << server.user
              << '\n';
  return ExitCode::done;
}

struct WebLineOptions {
  bool json = false;
};

ExitCode run(const WebLineOptions& options, Program& program) {
  Connection connection = program.connect();
  const auto line = connection.call(&Stub::IssueSignIn, v1::IssueSignInRequest());
  if (line.link().empty())
    throw CommandFailed(
        ExitCode::wrong_state,
        connection.server() +
            " names no address of dccast-web (access.web_address); an admin sets it");
  const std::string end = utc_text(line.expire_time().seconds());
  if (options.json) {
    print_line({{"link", line.link()}, {"expires", end}});
    return ExitCode::done;
  }
  std::cout << line.link() << std::endl;
  std::cerr << "Open it in a browser: it signs in once, until " << end << '\n';
  return ExitCode::done;
}

struct TokensOptions {
  std::string end;
  bool json = false;
};

Json token_json(const v1::Token& token) {
  const auto time = [](bool is_known, const google::protobuf::Timestamp& at) {
    return is_known ? Json(utc_text(at.seconds())) : Json();
  };
  return {{"id", token.id()},
          {"name", token.name()},
          {"made", time(true, token.create_time())},
          {"expires", time(true, token.expire_time())},
          {"last_use", time(token.has_last_use_time(), token.last_use_time())},
          {"from", token.last_use_address()},
          {"is_line", token.is_secret()},
          {"is_this_login", token.is_of_this_call()}};
}

ExitCode run(const TokensOptions& options, Program& program) {
  Connection connection = program.connect();
  if (!options.end.empty()) {
    v1::RevokeTokenRequest revoked;
    revoked.set_id(options.end);
    connection.call(&Stub::RevokeToken, revoked);
    std::cerr << "token " << options.end << " was revoked\n";
    return ExitCode::done;
  }

  const auto all = connection.call(&Stub::ListTokens, v1::ListTokensRequest());
  if (options.json) {
    print_line(json_list(all.tokens(), token_json));
    return ExitCode::done;
  }
  for (const v1::Token& token : all.tokens()) {
    std::cout << token.id() << "  " << (token.is_secret() ? "line, not used yet" : token.name())
              << ", made " << utc_text(token.create_time().seconds());
    if (token.has_last_use_time())
      std::cout << ", used " << utc_text(token.last_use_time().seconds()) << " from "
                << token.last_use_address();
    std::cout << ", until " << utc_text(token.expire_time().seconds())
              << (token.is_of_this_call() ? "  (this login)" : "") << '\n';
  }
  if (all.tokens().empty()) std::cerr << "you have no tokens here\n";
  return ExitCode::done;
}

struct DoctorOptions {
  std::string server, role;
  int timeout_s = 5;
};

ExitCode run(const DoctorOptions& options, Program& program) {
  const std::string text = options.server.empty() ? program.server : options.server;
  const StoredServers servers(program.servers);
  const StoredServer* stored = servers.find(text);
  Endpoint endpoint = stored != nullptr ? stored->endpoint : Endpoint{.address = text};
  if (endpoint.address.empty()) endpoint.address = address_of(values::local_server());
  std::vector<std::string> found;
  const Diagnosis diagnosis = diagnose(endpoint,
                                       {.timeout = std::chrono::seconds(options.timeout_s),
                                        .role = options.role,
                                        .version = DCCAST_VERSION},
                                       found, program.interruption);
  for (const std::string& line : found) std::cout << "ok      " << line << '\n';
  if (diagnosis.sound()) return ExitCode::done;
  std::cout << "cause   " << diagnosis.cause << "\nremedy  " << diagnosis.remedy << '\n';
  return ExitCode::unreachable;
}

}  // namespace

void add_login(CommandLine& line, Program& program) {
  const auto [command, options] = declare<LoginOptions>(
      line, program, run, "login", "Log in to a server with the line of `dccastd user add`",
      "dccast login                      asks for the line\n"
      "  dccast login --renew              a new token in place of one that ends soon\n"
      "  dccast login --name north < line.txt");
  command.option("LINE", options.words,
                 "The line, optionally after another address; read from standard input if absent",
                 {.count = {{0, 2}}});
  command.option("--name", options.name, "Name for --server; else that of the host");
  command.flag("--renew", options.renew, "Exchange the token for a new one with its full life");
  command.flag("--default", options.first, "Make this the default server");
}

void add_logout(CommandLine& line, Program& program) {
  line.command("logout", "Revoke the token and forget the server", "dccast --server north logout")
      .action([&program] { return log_out(program); });
}

void add_whoami(CommandLine& line, Program& program) {
  const auto [command, options] = declare<WhoAmIOptions>(
      line, program, run, "whoami", "Name, role and end of the login", "dccast whoami");
  command.json(options.json);
}

void add_web_line(CommandLine& line, Program& program) {
  const auto [command, options] = declare<WebLineOptions>(
      line, program, run, "web-line",
      "Print a link that signs in a browser once, within ten minutes", "dccast web-line");
  command.json(options.json);
}

void add_tokens(CommandLine& line, Program& program) {
  const auto [command, options] = declare<TokensOptions>(
      line, program, run, "tokens", "List your logins and sessions of browsers, or end one",
      "dccast tokens\n  dccast tokens --end 0123456789abcdef");
  command.option("--end", options.end, "Id of the token that is revoked");
  command.json(options.json);
}

void add_doctor(CommandLine& line, Program& program) {
  const auto [command, options] = declare<DoctorOptions>(
      line, program, run, "doctor", "Why calls to a server fail: the cause and its remedy",
      "dccast doctor casthouse:7118");
  command.option("SERVER", options.server, "Name or address; else the default");
  command.option("--role", options.role, "Also whether the user has this role",
                 {.one_of = {"viewer", "submitter", "admin"}});
  command.number("--timeout", options.timeout_s, 1, 60, "Seconds to wait in each step");
}

}  // namespace dccast::client
