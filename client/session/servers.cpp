#include "client/session/servers.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <sstream>

#include <toml++/toml.h>

#include "client/session/private_file.hpp"
#include "client/session/socket.hpp"
#include "proto/values/address.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client {
namespace {

namespace fs = std::filesystem;

constexpr const char* sha256_begins = "sha256:";

/// The keys of a server in the file, in their order, with the members that they set.
std::array<std::pair<const char*, std::string*>, 8> texts_of(StoredServer& server) {
  Endpoint& to = server.endpoint;
  return {{{"name", &server.name},
           {"address", &to.address},
           {"user", &server.user},
           {"token", &to.token},
           {"expires", &server.expires},
           {"certificate", &to.certificate},
           {"key", &to.key},
           {"ca", &to.ca}}};
}

StoredServer read(const toml::table& table) {
  StoredServer server;
  for (const auto& [key, value] : texts_of(server)) *value = table[key].value_or(std::string());
  return server;
}

toml::table table_of(StoredServer server) {
  toml::table table;
  for (const auto& [key, value] : texts_of(server))
    if (!value->empty()) table.insert(key, *value);
  return table;
}

void take_token(const v1::EnrolResponse& response, StoredServer& server) {
  server.endpoint.token = response.token();
  server.user = response.user().name();
  server.expires = std::to_string(response.user().expire_time().seconds());
}

[[noreturn]] void fail(const fs::path& file, const std::string& fault) {
  throw invalid(file.string() + ": " + fault);
}

}  // namespace

bool StoredServer::ends_soon() const {
  constexpr std::int64_t warned_before_s = 14 * 86400;
  return !expires.empty() && std::atoll(expires.c_str()) - std::time(nullptr) < warned_before_s;
}

StoredServers::StoredServers(fs::path file) : file_(std::move(file)) {
  std::error_code error;
  if (file_.empty() || !fs::exists(file_, error)) return;
  // Tokens in the file stand for the user: a file that others may read is refused, not mended.
  struct stat status;
  if (::stat(file_.c_str(), &status) == 0 && (status.st_mode & 0077) != 0)
    fail(file_, "other users may read the tokens in it; chmod 600 " + file_.string());
  try {
    const toml::table all = toml::parse_file(file_.string());
    if (const toml::array* servers = all["server"].as_array())
      for (const toml::node& one : *servers)
        if (one.is_table()) all_.push_back(read(*one.as_table()));
  } catch (const toml::parse_error& error_in_file) {
    fail(file_, "not valid TOML (" + std::string(error_in_file.description()) +
                    "); remove it and log in again");
  }
}

const StoredServer* StoredServers::find(const std::string& text) const {
  for (const StoredServer& server : all_)
    if (text.empty() || server.name == text || server.endpoint.address == text) return &server;
  for (const StoredServer& server : all_)
    if (values::host_and_port(server.endpoint.address).host == text) return &server;
  return nullptr;
}

void StoredServers::store(const StoredServer& server, bool first) {
  std::erase_if(all_, [&](const StoredServer& one) { return one.name == server.name; });
  all_.insert(first ? all_.begin() : all_.end(), server);
  write();
}

void StoredServers::remove(const std::string& name) {
  std::erase_if(all_, [&](const StoredServer& one) { return one.name == name; });
  write();
}

/// Replaces the file by a new one that others can never read.
void StoredServers::write() const {
  if (file_.empty()) throw invalid("there is no folder for the login: set HOME or XDG_CONFIG_HOME");

  toml::array servers;
  for (const StoredServer& server : all_) servers.push_back(table_of(server));
  std::ostringstream content;
  content << "# Written by dccast login; with its tokens anyone can call as you.\n"
          << toml::table{{"server", servers}} << '\n';

  const std::string fault = write_private_file(file_, content.str());
  if (!fault.empty()) fail(file_, "cannot be written: " + fault);
}

Endpoint endpoint_of(const std::string& server) {
  const Endpoint endpoint{.address = address_of(server)};
  if (endpoint.is_local()) return endpoint;
  throw CommandFailed(
      ExitCode::unreachable,
      fmt::format("there is no login for {}; log in with the line of `dccastd user add`: dccast "
                  "login.{} Why a connection fails: dccast doctor {}",
                  endpoint.address,
                  values::is_loopback(endpoint.address)
                      ? " Local users give no --server: dccastd serves them at a Unix socket."
                      : "",
                  endpoint.address));
}

EnrolmentLine read_enrolment_line(const std::string& line) {
  std::string words = line;
  while (!words.empty() && std::isspace(static_cast<unsigned char>(words.back()))) words.pop_back();
  if (const auto blank = words.find_last_of(" \t"); blank != std::string::npos)
    words = words.substr(blank + 1);  // "dccast login LINE" as it was printed
  const auto first = words.find('/');
  const auto second = first == std::string::npos ? first : words.find('/', first + 1);
  const std::string fingerprint =
      second == std::string::npos ? "" : words.substr(first + 1, second - first - 1);
  constexpr std::size_t digits = 64;
  if (!fingerprint.starts_with(sha256_begins) ||
      fingerprint.size() != std::strlen(sha256_begins) + digits || first == 0 ||
      second + 1 == words.size())
    throw invalid("\"" + values::shown(line) +
                  "\" is not the line of `dccastd user add`: HOST:PORT/sha256:FINGERPRINT/SECRET");
  return {words.substr(0, first), fingerprint.substr(std::strlen(sha256_begins)),
          words.substr(second + 1)};
}

void renew_token(StoredServer& server, std::shared_ptr<Interruption> interruption) {
  Connection connection(server.endpoint, interruption);
  v1::EnrolRequest request;
  request.set_secret(server.endpoint.token);
  request.set_machine(host_name());
  v1::EnrolResponse response;
  check(connection.try_once(&Stub::Enrol, request, response), connection.server());
  take_token(response, server);
}

StoredServer log_in(const EnrolmentLine& line, const std::string& name,
                    std::shared_ptr<Interruption> interruption) {
  StoredServer server{name, {.address = line.address}, ""};
  server.endpoint.ca = certificate_with_fingerprint(line.address, line.fingerprint, {});

  // Not repeated: the secret is valid once.
  Connection connection(server.endpoint, interruption);

  v1::EnrolRequest request;
  request.set_secret(line.secret);
  request.set_machine(host_name());
  v1::EnrolResponse response;
  const grpc::Status status = connection.try_once(&Stub::Enrol, request, response);

  if (status.error_code() == grpc::StatusCode::UNAVAILABLE) {
    std::vector<std::string> found;
    const Diagnosis why = diagnose(server.endpoint, {}, found, interruption);
    if (!why.sound()) throw CommandFailed(ExitCode::unreachable, why.cause + "; " + why.remedy);
  }

  check(status, line.address);
  take_token(response, server);
  return server;
}

}  // namespace dccast::client
