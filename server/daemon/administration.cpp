#include "server/daemon/daemon.hpp"

#include <fmt/chrono.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <ostream>

#include "core/storage/file.hpp"
#include "core/storage/storage_error.hpp"
#include "proto/values/address.hpp"
#include "server/access/certificates.hpp"
#include "server/access/users.hpp"
#include "server/service/gate.hpp"
#include "server/state/state_folder.hpp"

namespace dccast::daemon {

namespace {

namespace fs = std::filesystem;
using access::Refused;

constexpr int server_days = 90, user_days = 365;
constexpr std::int64_t day_s = 86400;
constexpr std::int64_t renewed_before_s = 30 * day_s;

std::string date(std::int64_t unix_s) {
  return fmt::format("{:%Y-%m-%d %H:%MZ}", fmt::gmtime(unix_s));
}

fs::path data_directory(const v1::DaemonConfig& config) {
  const state::StateFolder folder(config.data_directory());
  state::make_state_folder(folder);
  return folder.path();
}

/// Who is at the keyboard: behind sudo the one who called it.
std::string who_commands() {
  if (const char* behind = std::getenv("SUDO_USER"); behind != nullptr && ::geteuid() == 0)
    return behind;
  return service::user_name(::getuid());
}

/// What root has made here is the daemon's, whose user the directory belongs to.
void give_to_owner(const fs::path& directory) {
  struct stat owner;
  if (::geteuid() != 0 || ::stat(directory.c_str(), &owner) != 0 || owner.st_uid == 0) return;
  for (const char* name : {"users.toml", "users.lock", "audit.log", "pki", "pki/ca.pem",
                           "pki/ca.key", "pki/server.pem", "pki/server.key"})
    if (::lchown((directory / name).c_str(), owner.st_uid, owner.st_gid) != 0 && errno != ENOENT)
      throw storage::StorageError(errno, (directory / name).string(),
                                  "cannot be given to the owner of the directory");
}

void record(const AdministrationCommand& command, const fs::path& directory,
            const std::string& what) {
  v1::AuditEvent event;
  event.set_user(who_commands());
  event.set_proof("command");
  event.set_call("dccastd " + command.verb);
  event.set_outcome("OK");
  event.set_reason(what);
  access::AuditLog(directory).append(event);
}

access::Certificate read(const fs::path& file) {
  return access::read_certificate(storage::read_file(file, storage::Links::follow), file.string());
}

bool is_any(const std::string& host) {
  return host.empty() || host == "0.0.0.0" || host == "::";
}

/// Names of the certificate: this machine's, and those of the settings.
std::vector<std::string> server_names(const v1::DaemonConfig& config) {
  auto names = access::names_of_this_machine();
  for (const std::string& address : {config.listen_tls(), config.public_address()}) {
    const std::string host = values::host_and_port(address).host;
    if (!is_any(host) && std::find(names.begin(), names.end(), host) == names.end())
      names.insert(names.begin(), host);
  }
  return names;
}

/// Host and port by which users reach the daemon.
std::string reached_at(const v1::DaemonConfig& config) {
  if (!config.public_address().empty()) return config.public_address();
  const std::string& listen = config.listen_tls();
  if (listen.empty())
    throw Refused(
        "listen_tls is not set: no one could log in. Set it in the settings, e.g. listen_tls = "
        "\"0.0.0.0:7118\", restart dccastd, and name the settings here, too (--config)");
  if (!is_any(values::host_and_port(listen).host)) return listen;
  return access::names_of_this_machine().front() + listen.substr(listen.rfind(':'));
}

/// What an admin hands over: where, which CA, and a secret that is good once.
std::string line_of(const std::string& address, const TlsFiles& files, const std::string& secret) {
  return address + "/sha256:" + read(files.ca).sha256 + "/" + secret;
}

void print_line(const AdministrationCommand& command, const v1::DaemonConfig& config,
                const std::string& secret, std::ostream& out) {
  const std::int64_t days = std::llround(config.enrolment_lifetime_s()) / day_s;
  out << "Hand this line to " << command.name << "; it is good once, for "
      << (days > 0 ? std::to_string(days) + " days"
                   : std::to_string(std::llround(config.enrolment_lifetime_s())) + " s")
      << ":\n\n    dccast login " << line_of(reached_at(config), prepare_tls(config), secret)
      << "\n\n";
}

void list_users(access::UserStore& users, std::ostream& out) {
  const v1::Users all = users.users();
  if (all.user_size() == 0) out << "no users; dccastd user add NAME --role submitter\n";
  for (const v1::User& user : all.user()) {
    out << user.name() << "  " << access::text_of(user.role())
        << (user.disabled() ? "  disabled" : "") << '\n';
    for (const v1::Credential& one : user.credential())
      out << "    " << (one.enrolment() ? "one-time line" : "token " + one.id())
          << (one.machine().empty() ? "" : " on " + one.machine())
          << (one.expires_unix() <= std::time(nullptr) ? ", expired " : ", until ")
          << date(one.expires_unix()) << '\n';
  }
}

void run_user(const AdministrationCommand& command, const v1::DaemonConfig& config,
              std::ostream& out) {
  const fs::path directory = data_directory(config);
  access::UserStore users(directory);
  const std::string verb = command.verb.substr(5);
  const std::string& name = command.name;
  if (verb == "list") return list_users(users, out);
  const std::int64_t ends = std::time(nullptr) + std::llround(config.enrolment_lifetime_s());
  std::string done = verb + " " + name;
  if (verb == "add" || verb == "rotate") {
    reached_at(config);  // refused before anything is changed
    const std::string secret =
        verb == "add" ? users.add(name, access::role_of(command.role), std::time(nullptr), ends)
                      : users.rotate(name, std::time(nullptr), ends);
    if (verb == "add") done += " as " + command.role;
    print_line(command, config, secret, out);
  } else if (verb == "remove") {
    users.remove(name);
  } else if (verb == "role") {
    users.set_role(name, access::role_of(command.role));
    done += " " + command.role;
  } else {
    users.set_disabled(name, verb == "disable");
  }
  record(command, directory, done);
  if (verb != "add" && verb != "rotate") out << done << ": done; it holds at once\n";
}

void show(const std::string& what, const fs::path& file, std::ostream& out) {
  const access::Certificate certificate = read(file);
  out << what << "  " << certificate.name << "\n  file         " << file.string()
      << "\n  valid        " << date(certificate.begins_unix) << " to "
      << date(certificate.ends_unix)
      << (certificate.ends_unix <= std::time(nullptr) ? "  EXPIRED" : "")
      << "\n  fingerprint  sha256:" << certificate.sha256 << '\n';
  if (certificate.names.empty()) return;
  out << "  names       ";
  for (const std::string& name : certificate.names) out << ' ' << name;
  out << '\n';
}

void run_pki(const AdministrationCommand& command, const v1::DaemonConfig& config,
             std::ostream& out) {
  const fs::path directory = data_directory(config);
  const access::Pki pki(directory);
  const std::string verb = command.verb.substr(4);
  if (verb != "show" && !config.certificate().empty())
    throw Refused("the settings name a certificate of their own: " + config.certificate() +
                  "; who issued it renews it, and dccastd takes it up within seconds");
  if (verb == "init") pki.init();
  if (verb != "init" && verb != "show" && !pki.exists())
    throw Refused("there is no CA yet; dccastd pki init makes it");
  if (verb == "init" || verb == "renew") {
    auto names = server_names(config);
    if (verb == "renew" && fs::exists(pki.server())) names = read(pki.server()).names;
    names.insert(names.begin(), command.names.begin(), command.names.end());
    pki.issue_server(names, command.days > 0 ? command.days : server_days);
  }
  if (verb == "issue") {
    pki.issue_user(command.name, command.days > 0 ? command.days : user_days, command.directory);
    out << "wrote " << (fs::path(command.directory) / command.name).string()
        << ".pem and .key; the user needs a role (dccastd user add), and the settings client_ca = "
           "\""
        << pki.ca().string() << "\"\n";
  }
  if (verb != "show") record(command, directory, verb + " " + command.name);
  if (verb == "issue") return;
  const TlsFiles files = prepare_tls(config);
  show("CA", files.ca, out);
  show("server", files.certificate, out);
}

}  // namespace

TlsFiles prepare_tls(const v1::DaemonConfig& config) {
  if (!config.certificate().empty()) {
    if (config.certificate_key().empty() || config.certificate_ca().empty())
      throw Refused("certificate is set: set certificate_key and certificate_ca, too");
    TlsFiles files{config.certificate(), config.certificate_key(), config.certificate_ca(),
                   config.client_ca()};
    for (const std::string& file : {files.certificate, files.ca}) read(file);
    return files;
  }
  const access::Pki pki(data_directory(config));
  if (!pki.exists()) pki.init();
  const bool there = fs::exists(pki.server());
  if (!there || read(pki.server()).ends_unix - std::time(nullptr) < renewed_before_s)
    pki.issue_server(there ? read(pki.server()).names : server_names(config), server_days);
  return {pki.server(), pki.server_key(), pki.ca(), config.client_ca(), true};
}

void administrate(const AdministrationCommand& command, const v1::DaemonConfig& config,
                  std::ostream& out) {
  const fs::path directory = data_directory(config);
  if (command.verb.starts_with("user ")) run_user(command, config, out);
  if (command.verb.starts_with("pki ")) run_pki(command, config, out);
  if (command.verb == "audit") access::print_audit(directory, command.filter, out);
  give_to_owner(directory);
}

}  // namespace dccast::daemon
