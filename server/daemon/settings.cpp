#include "server/daemon/settings.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <iostream>
#include <sstream>
#include <string_view>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/source_map.hpp"
#include "proto/values/address.hpp"
#include "proto/values/local_socket.hpp"

namespace dccast::daemon {

namespace {

void add_settings(CLI::App& app, CommandLine& line) {
  app.add_option("--config", line.config_file,
                 "Settings, TOML; every key has a default, see deploy/config/dccastd.toml. Without "
                 "this, /usr/bin/dccastd takes /etc/dccast/dccastd.toml");
  app.add_option("--set", line.overrides,
                 "One setting over the file's, e.g. --set workers.count=2; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

void add_worker_policy(CLI::App& app, WorkerPolicy& policy) {
  app.add_option(
         "--worker-patience", policy.patience_s,
         "How long workers run on after a crash of dccastd and wait for the next one, which "
         "goes on with them; then they stop at a checkpoint. 0: they end at once")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  app.add_flag("--leave-workers", policy.left_running,
               "At SIGTERM and SIGINT, leave running jobs to their workers, as a crash does");
}

/// @param verb  of Command::administrate
CLI::App& add_command(CLI::App& app, CommandLine& line, const char* name, const char* help,
                      Command command, const std::string& verb = {}) {
  CLI::App* added = app.add_subcommand(name, help);
  add_settings(*added, line);
  added->callback([&line, command, verb] {
    line.command = command;
    line.administration.verb = verb;
  });
  return *added;
}

/// Adds `dccastd GROUP VERB`.
CLI::App& add_verb(CLI::App& group, CommandLine& line, const char* verb, const char* help) {
  return add_command(group, line, verb, help, Command::administrate, group.get_name() + " " + verb);
}

CLI::App& add_group(CLI::App& app, const char* name, const char* help) {
  CLI::App* group = app.add_subcommand(name, help);
  group->require_subcommand(1);
  return *group;
}

void add_user_commands(CLI::App& app, CommandLine& line) {
  CLI::App& group =
      add_group(app, "user", "Users of other machines; dccastd may be running or not");
  AdministrationCommand& asked = line.administration;

  const auto named = [&](const char* verb, const char* help) -> CLI::App& {
    CLI::App& added = add_verb(group, line, verb, help);
    added.add_option("NAME", asked.name, "As jobs name their owner")->required();
    return added;
  };

  named("add", "Add a user, and print the line to hand over")
      .add_option("--role", asked.role, "viewer, submitter or admin")
      ->capture_default_str();
  named("line", "Print a line for one more token; revokes nothing")
      .add_option("--for", asked.token, "Name of the token, e.g. night-script; else the machine's");
  named("revoke", "Revoke one token")
      .add_option("TOKEN", asked.token, "Its id, see user list")
      ->required();
  named("rotate", "Revoke all of a user's credentials, and print a new line");
  named("remove", "Remove a user; their jobs stay");
  named("disable", "Answer no call of a user");
  named("enable", "Undo disable");
  named("role", "Change a role")
      .add_option("ROLE", asked.role, "viewer, submitter or admin")
      ->required();
  add_verb(group, line, "list", "Users with their tokens");
}

void add_pki_commands(CLI::App& app, CommandLine& line) {
  CLI::App& group = add_group(app, "pki", "The daemon's own CA and certificate");
  AdministrationCommand& asked = line.administration;

  const auto with_names = [&](const char* verb, const char* help) {
    CLI::App& added = add_verb(group, line, verb, help);
    added.add_option("--name", asked.names, "A further name or address of this server")
        ->allow_extra_args(false);
    added.add_option("--days", asked.days, "Validity of the certificate in days, usually 90");
  };

  with_names("init", "Create them; serve does so when first needed");
  with_names("renew", "Make a new certificate of the same CA, used without a restart");

  CLI::App& issue = add_verb(group, line, "issue", "A client certificate in place of a token");
  issue.add_option("NAME", asked.name, "A user")->required();
  issue.add_option("--to", asked.directory, "Where NAME.pem and NAME.key are written")->required();
  issue.add_option("--days", asked.days, "Validity of the certificate in days, usually 365");

  add_verb(group, line, "show", "Names, validity and fingerprints");
}

void add_audit_command(CLI::App& app, CommandLine& line) {
  AdministrationCommand& asked = line.administration;
  CLI::App& audit = add_command(app, line, "audit", "Who did what, one line of JSON an event",
                                Command::administrate, "audit");
  audit.add_option("--user", asked.filter.user, "Only of this user");
  audit.add_option("--job", asked.filter.job, "Only of this job; the beginning of an id is enough");
  audit.add_option("--call", asked.filter.call, "Only this call, e.g. SubmitJob");
  audit.add_option("--since", asked.filter.since,
                   "From this time on: today, \"3 h\", 2026-11-23T08, as dccast list takes it");
}

void add_commands(CLI::App& app, CommandLine& line) {
  app.require_subcommand(0, 1);

  add_worker_policy(
      add_command(app, line, "serve", "Serve; the same as no command", Command::serve),
      line.workers);

  CLI::App& check = add_command(
      app, line, "check", "Inspect the data directory while no dccastd uses it", Command::check);
  check.add_flag("--repair", line.repair, "Repair what can be repaired, and print what was done");
  check.add_flag("--deep", line.deep, "Also hold all results against their SHA-256");
  check.add_option("--adopt", line.adopt, "Take a job back out of quarantine; may be repeated")
      ->type_name("ID")
      ->allow_extra_args(false);

  add_command(app, line, "check-config",
              "Print all faults of the settings; exit code 2 if there is one",
              Command::check_config);

  CLI::App& backup =
      add_command(app, line, "backup", "Copy the data directory; its dccastd may keep running",
                  Command::backup);
  backup.add_option("--to", line.directory, "A new or empty directory")->required();
  backup
      .add_option("--earlier", line.earlier,
                  "A backup on the same file system: what it has already is linked, not kept twice")
      ->type_name("DIR");
  add_command(app, line, "restore", "Restore the data directory from a backup, and check it",
              Command::restore)
      .add_option("--from", line.directory, "What dccastd backup wrote")
      ->required();
  add_user_commands(app, line);
  add_pki_commands(app, line);
  add_audit_command(app, line);
}

constexpr std::array<std::string_view, 5> log_levels{"trace", "debug", "info", "warn", "error"};

void add(const std::vector<v1::Fault>& faults, const std::string& where, std::string& text) {
  for (const v1::Fault& fault : faults)
    text += where + ": " + case_file::describe(fault, {}) + "\n";
}

/// One "key=value" as a line of TOML. A value that is not TOML is taken as text, because quotes are
/// inconvenient on a command line.
void override_key(const std::string& override_text, v1::DaemonConfig& config, std::string& faults) {
  const std::string where = "--set " + override_text;
  const auto equals = override_text.find('=');
  if (equals == std::string::npos) {
    faults += where + ": write it as key=value\n";
    return;
  }

  const std::string key = override_text.substr(0, equals);
  const std::string value = override_text.substr(equals + 1);
  v1::DaemonConfig one;
  auto outcome = case_file::read_text(key + " = " + value, where, one);

  if (!outcome.ok()) {
    one.Clear();
    const auto quoted = case_file::read_text(key + " = '" + value + "'", where, one);
    // A fault of a key is about a value that is TOML.
    const bool is_toml = !outcome.faults.front().field().empty();
    if (!quoted.ok()) return add(is_toml ? outcome.faults : quoted.faults, where, faults);
  }

  config.MergeFrom(one);
}

/// The address of local users, which is never one of TCP.
void check_listen(const std::string& listen, std::string& faults) {
  if (listen.empty() || listen.starts_with(values::unix_scheme)) return;
  faults += fmt::format(
      "listen.socket = {}: permitted: unix:PATH of a socket, or nothing for the usual one, where "
      "local "
      "clients look first; TCP needs TLS and a token: for other users write the address as "
      "listen.tls, see docs/remote.md\n",
      listen);
}

/// squeue and scancel look at the cluster of this machine: jobs of another one would count as lost.
void check_slurm_options(const std::string& options, std::string& faults) {
  std::istringstream words(options);
  for (std::string word; words >> word;)
    if (word.starts_with("--cluster") || word.starts_with("-M"))
      faults += fmt::format(
          "slurm.options: {}: permitted: options of sbatch but --clusters, since dccastd looks for "
          "its jobs in one cluster; run a dccastd on a machine of that cluster\n",
          word);
}

void check_host_and_port(const std::string& key, const std::string& listen, std::string& faults) {
  if (!values::port_of(listen))
    faults += key + " = " + listen +
              ": permitted: host:port, with a port of 0 to 65535, e.g. 127.0.0.1:7118; 0 takes a "
              "free one, see listen.port_file\n";
}

/// It becomes the begin of links, which a browser opens. The page would not count as its own
/// under another one.
void check_web_address(const std::string& address, std::string& faults) {
  if (address.empty() || values::is_web_origin(address)) return;
  faults += "access.web_address = " + address +
            ": permitted: https://NAME or https://NAME:PORT, without a path; write what browsers "
            "open, e.g. https://dccast.plant.example\n";
}

}  // namespace

std::string usual_settings(const std::filesystem::path& program) {
  const std::filesystem::path of_package = "/etc/dccast/dccastd.toml";
  return program == "/usr/bin/dccastd" && std::filesystem::exists(of_package) ? of_package.string()
                                                                              : "";
}

CommandLine read_command_line(int argc, char** argv) {
  CommandLine line;
  CLI::App app(
      "dccastd: simulation service for DC-cast slabs. Takes jobs over gRPC, runs each in a "
      "worker process, keeps events and results.",
      "dccastd");

  add_settings(app, line);
  add_worker_policy(app, line.workers);
  add_commands(app, line);

  app.set_version_flag("--version", "dccastd " DCCAST_VERSION);
  app.footer(
      "Example: dccastd --config deploy/config/dccastd.toml --set workers.count=2\n"
      "SIGTERM and SIGINT stop running jobs at a checkpoint; the next start goes on with them. "
      "SIGUSR1 "
      "leaves them running for it.\n"
      "Exit codes: 0 stopped as asked, or sound; 2 usage or invalid settings; 3 damage is left in "
      "the "
      "data directory; 4 the address or the data directory cannot be used.");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    line.exit_code = app.exit(error, std::cout, std::cerr) == 0 ? 0 : 2;
  }

  if (line.config_file.empty())
    line.config_file = usual_settings(std::filesystem::read_symlink("/proc/self/exe"));
  return line;
}

v1::DaemonConfig read_config(const std::string& file, const std::vector<std::string>& overrides) {
  v1::DaemonConfig config;
  std::string faults;

  if (!file.empty()) add(case_file::read_file(file, config).faults, file, faults);
  for (const std::string& text : overrides) override_key(text, config, faults);

  case_file::apply_defaults(config);
  if (faults.empty()) add(case_file::check_ranges(config), "settings", faults);

  if (std::ranges::find(log_levels, config.log().level()) == log_levels.end())
    faults +=
        "log.level = " + config.log().level() + ": permitted: trace, debug, info, warn, error\n";

  check_listen(config.listen().socket(), faults);
  check_slurm_options(config.slurm().options(), faults);
  if (!config.listen().metrics().empty())
    check_host_and_port("listen.metrics", config.listen().metrics(), faults);
  if (const std::string& hook = config.job_end_hook();
      !hook.empty() && (hook.front() != '/' || ::access(hook.c_str(), X_OK) != 0))
    faults += "job_end_hook = " + hook + ": permitted: the absolute path of a program\n";
  if (!config.listen().tls().empty())
    check_host_and_port("listen.tls", config.listen().tls(), faults);

  check_web_address(config.access().web_address(), faults);

  if (!faults.empty()) throw InvalidConfig(faults.substr(0, faults.size() - 1));
  return config;
}

}  // namespace dccast::daemon
