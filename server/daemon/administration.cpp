#include "server/daemon/daemon.hpp"

#include <fmt/chrono.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <optional>
#include <ostream>

#include "core/storage/file.hpp"
#include "core/storage/storage_error.hpp"
#include "proto/values/address.hpp"
#include "proto/values/printable.hpp"
#include "proto/values/times.hpp"
#include "server/access/certificates.hpp"
#include "server/access/machine_names.hpp"
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

/// Of a command that reads: it makes no folder, and says which one it reads.
fs::path existing_data_directory(const v1::DaemonConfig& config) {
  const fs::path directory = fs::absolute(config.data_directory());
  if (!fs::is_directory(directory))
    throw Refused(
        fmt::format("there is no data directory {}; name the settings of dccastd (--config)",
                    directory.string()));
  std::cerr << "data directory " << directory.string() << '\n';
  return directory;
}

/// The user who runs this command; behind sudo the one who called it.
std::string commanding_user() {
  if (const char* behind = std::getenv("SUDO_USER"); behind != nullptr && ::geteuid() == 0)
    return behind;
  return service::user_name(::getuid());
}

/// Gives files that root has created to the owner of the directory, who runs the daemon.
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
            const std::string& change) {
  v1::AuditEvent event;
  event.set_user(commanding_user());
  event.set_proof("command");
  event.set_call(fmt::format("dccastd {}", command.verb));
  event.set_outcome("OK");
  event.set_reason(change);
  access::AuditLog(directory).append(event);
}

access::Certificate read(const fs::path& file) {
  return access::read_certificate(storage::read_file(file, storage::Links::follow), file.string());
}

bool is_any_address(const std::string& host) {
  return host.empty() || host == "0.0.0.0" || host == "::";
}

/// Names for the certificate: those of this machine and of the settings.
std::vector<std::string> server_names(const v1::DaemonConfig& config) {
  auto names = access::host_names();
  for (const std::string& address : {config.listen().tls(), config.listen().public_address()}) {
    const std::string host = values::host_and_port(address).host;
    if (!is_any_address(host) && std::find(names.begin(), names.end(), host) == names.end())
      names.insert(names.begin(), host);
  }
  return names;
}

/// Host and port by which users reach the daemon.
std::string login_address(const v1::DaemonConfig& config) {
  if (!config.listen().public_address().empty()) return config.listen().public_address();
  const std::string& listen = config.listen().tls();
  if (listen.empty())
    throw Refused(
        "listen.tls is not set: no one could log in. Set it in the settings, e.g. tls = "
        "\"0.0.0.0:7118\" below [listen], restart dccastd, and name the settings here, too "
        "(--config)");
  if (!is_any_address(values::host_and_port(listen).host)) return listen;
  return access::host_names().front() + listen.substr(listen.rfind(':'));
}

/// The line that an admin hands over: address, fingerprint of the CA, one-time secret.
std::string login_line(const std::string& address, const TlsFiles& files,
                       const std::string& secret) {
  return fmt::format("{}/sha256:{}/{}", address, read(files.ca).sha256, secret);
}

void print_line(const AdministrationCommand& command, const v1::DaemonConfig& config,
                const std::string& secret, std::ostream& out) {
  const std::int64_t seconds = std::llround(config.access().enrolment_lifetime_s());
  const std::int64_t days = seconds / day_s;
  const std::string lifetime =
      days > 0 ? fmt::format("{} days", days) : fmt::format("{} s", seconds);
  const std::string& web = config.access().web_address();
  const bool is_for_programs = web.empty() || !config.listen().tls().empty();
  out << fmt::format("Hand this {} to {}; it is good once, for {}:\n\n",
                     is_for_programs ? "line" : "link", command.name, lifetime);
  if (is_for_programs)
    out << fmt::format("    dccast login {}\n\n",
                       login_line(login_address(config), prepare_tls(config), secret));
  if (is_for_programs && !web.empty()) out << "or, for a browser, this link in its place:\n\n";
  if (!web.empty()) out << fmt::format("    {}\n\n", access::sign_in_link(web, secret));
}

void list_users(const fs::path& directory, std::ostream& out) {
  const v1::Users all = access::UserStore(directory).users();
  if (all.user_size() == 0) out << "no users; dccastd user add NAME --role submitter\n";

  for (const v1::User& user : all.user()) {
    out << user.name() << "  " << access::text_of(user.role())
        << (user.disabled() ? "  disabled" : "") << '\n';
    for (const v1::Credential& credential : user.credential()) {
      const bool has_expired = credential.expires_unix() <= std::time(nullptr);
      out << "    " << (credential.enrolment() ? "one-time line" : "token " + credential.id())
          << (credential.machine().empty() ? "" : " on " + credential.machine())
          << (has_expired ? ", expired " : ", until ") << date(credential.expires_unix()) << '\n';
    }
  }
}

void run_user(const AdministrationCommand& command, const v1::DaemonConfig& config,
              const fs::path& directory, std::ostream& out) {
  access::UserStore users(directory);
  const std::string verb = command.verb.substr(5);
  const std::string& name = command.name;

  const bool gives_line = verb == "add" || verb == "line" || verb == "rotate";
  const std::int64_t now = std::time(nullptr);
  const std::int64_t ends = now + std::llround(config.access().enrolment_lifetime_s());
  std::string change = fmt::format("{} {}", verb, name);
  if (gives_line) {
    // May be refused, before anything is changed.
    if (config.access().web_address().empty()) login_address(config);
    const std::string secret = verb == "add"
                                   ? users.add(name, access::parse_role(command.role), now, ends)
                               : verb == "line" ? users.add_line(name, command.token, now, ends)
                                                : users.rotate(name, now, ends);
    if (verb == "add") change += fmt::format(" as {}", command.role);
    print_line(command, config, secret, out);
  } else if (verb == "revoke") {
    if (!users.revoke(name, command.token))
      throw Refused(fmt::format("user {} has no token {}; dccastd user list shows those there are",
                                name, values::shown(command.token)));
    change += " " + command.token;
  } else if (verb == "remove") {
    users.remove(name);
  } else if (verb == "role") {
    users.set_role(name, access::parse_role(command.role));
    change += fmt::format(" {}", command.role);
  } else {
    users.set_disabled(name, verb == "disable");
  }

  record(command, directory, change);
  if (!gives_line) out << change << ": done; it holds at once\n";
}

void show(const std::string& subject, const fs::path& file, std::ostream& out) {
  const access::Certificate certificate = read(file);
  out << subject << "  " << certificate.name << "\n  file         " << file.string()
      << "\n  valid        " << date(certificate.begins_unix) << " to "
      << date(certificate.ends_unix)
      << (certificate.ends_unix <= std::time(nullptr) ? "  EXPIRED" : "")
      << "\n  fingerprint  sha256:" << certificate.sha256 << '\n';
  if (certificate.names.empty()) return;

  out << "  names       ";
  for (const std::string& name : certificate.names) out << ' ' << name;
  out << '\n';
}

/// The TLS files of the settings; empty if these name none.
std::optional<TlsFiles> configured_tls(const v1::DaemonConfig& config) {
  if (config.tls().certificate().empty()) return std::nullopt;
  if (config.tls().key().empty() || config.tls().ca().empty())
    throw Refused("tls.certificate is set: set tls.key and tls.ca, too");

  TlsFiles files{config.tls().certificate(), config.tls().key(), config.tls().ca(),
                 config.tls().client_ca()};
  for (const std::string& file : {files.certificate, files.ca}) read(file);
  return files;
}

void show_pki(const v1::DaemonConfig& config, const fs::path& directory, std::ostream& out) {
  const access::Pki pki(directory);
  auto files = configured_tls(config);
  if (!files && !pki.exists())
    throw Refused(
        fmt::format("there is no CA in {} yet; dccastd creates it when it first serves "
                    "over TLS, or dccastd pki init",
                    directory.string()));
  if (!files) files = TlsFiles{pki.server(), pki.server_key(), pki.ca(), "", true};
  show("CA", files->ca, out);
  show("server", files->certificate, out);
  for (const std::string& fault : tls_faults(config, *files)) out << fault << '\n';
}

void run_pki(const AdministrationCommand& command, const v1::DaemonConfig& config,
             const fs::path& directory, std::ostream& out) {
  const access::Pki pki(directory);
  const std::string verb = command.verb.substr(4);
  if (!config.tls().certificate().empty())
    throw Refused(
        fmt::format("the settings name a certificate of their own: {}; its issuer renews it, and "
                    "dccastd takes it up within seconds",
                    config.tls().certificate()));
  if (verb == "init") pki.init();
  if (verb != "init" && !pki.exists())
    throw Refused("there is no CA yet; create it with dccastd pki init");

  if (verb == "init" || verb == "renew") {
    auto names = server_names(config);
    if (verb == "renew" && fs::exists(pki.server())) names = read(pki.server()).names;
    names.insert(names.begin(), command.names.begin(), command.names.end());
    pki.issue_server(names, command.days > 0 ? command.days : server_days);
  }

  if (verb == "issue") {
    pki.issue_user(command.name, command.days > 0 ? command.days : user_days, command.directory);
    out << fmt::format(
        "wrote {}.pem and .key; the user needs a role (dccastd user add), and the settings "
        "client_ca = \"{}\" below [tls]\n",
        (fs::path(command.directory) / command.name).string(), pki.ca().string());
  }

  record(command, directory, fmt::format("{} {}", verb, command.name));
  if (verb != "issue") show_pki(config, directory, out);
}

/// A time as `dccast list --since` takes it, as the log writes times.
std::string log_time(const std::string& since) {
  if (since.empty()) return {};
  const auto time = values::past_time(since, std::time(nullptr));
  if (!time)
    throw Refused(fmt::format("--since {}: no time; permitted: {}", values::shown(since),
                              values::past_times));
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}", fmt::gmtime(*time));
}

/// @return false: the command changes something
bool run_reader(const AdministrationCommand& command, const v1::DaemonConfig& config,
                std::ostream& out) {
  if (command.verb == "user list") {
    list_users(existing_data_directory(config), out);
  } else if (command.verb == "pki show") {
    show_pki(config, existing_data_directory(config), out);
  } else if (command.verb == "audit") {
    access::AuditFilter filter = command.filter;
    filter.since = log_time(filter.since);
    access::print_audit(existing_data_directory(config), filter, out);
  } else {
    return false;
  }
  return true;
}

}  // namespace

TlsFiles prepare_tls(const v1::DaemonConfig& config) {
  if (const auto files = configured_tls(config)) return *files;

  const access::Pki pki(data_directory(config));
  if (!pki.exists()) pki.init();

  const bool exists = fs::exists(pki.server());
  if (!exists || read(pki.server()).ends_unix - std::time(nullptr) < renewed_before_s)
    pki.issue_server(exists ? read(pki.server()).names : server_names(config), server_days);
  return {pki.server(), pki.server_key(), pki.ca(), config.tls().client_ca(), true};
}

std::vector<std::string> tls_faults(const v1::DaemonConfig& config, const TlsFiles& files) {
  const auto content = [](const std::string& file) {
    return storage::read_file(file, storage::Links::follow);
  };
  std::vector<std::string> faults;
  if (const std::string fault =
          access::signature_fault(content(files.certificate), content(files.ca));
      !fault.empty())
    faults.push_back(
        fmt::format("{} is not signed by the CA {} ({}): no client can log in; set "
                    "tls.ca to the certificate of its issuer",
                    files.certificate, files.ca, fault));

  const std::string host = values::host_and_port(config.listen().public_address().empty()
                                                     ? config.listen().tls()
                                                     : config.listen().public_address())
                               .host;
  if (!is_any_address(host) && !access::is_for(content(files.certificate), host))
    faults.push_back(
        fmt::format("{} is not for {}, by which clients call, but for {}; {}", files.certificate,
                    host, fmt::join(read(files.certificate).names, ", "),
                    files.own ? "dccastd pki renew --name " + host
                              : "get one for this name, or set listen.public_address"));
  return faults;
}

void administrate(const AdministrationCommand& command, const v1::DaemonConfig& config,
                  std::ostream& out) {
  if (run_reader(command, config, out)) return;

  const fs::path directory = data_directory(config);
  if (command.verb.starts_with("user ")) run_user(command, config, directory, out);
  if (command.verb.starts_with("pki ")) run_pki(command, config, directory, out);
  give_to_owner(directory);
}

}  // namespace dccast::daemon
