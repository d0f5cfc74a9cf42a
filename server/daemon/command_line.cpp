#include "server/daemon/command_line.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

namespace dccast::daemon {

namespace {

void add_settings(CLI::App& app, CommandLine& line) {
  app.add_option("--config", line.config_file,
                 "Settings, TOML; every key has a default, see deploy/config/dccastd.toml");
  app.add_option("--set", line.overrides,
                 "One setting over the file's, e.g. --set listen=127.0.0.1:0; may be repeated")
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
               "SIGTERM and SIGINT leave running jobs to their workers, as a crash does");
}

CLI::App& add_command(CLI::App& app, CommandLine& line, const char* name, const char* what,
                      Command command) {
  CLI::App* added = app.add_subcommand(name, what);
  add_settings(*added, line);
  added->callback([&line, command] { line.command = command; });
  return *added;
}

/// Adds `dccastd GROUP VERB`.
CLI::App& add_verb(CLI::App& group, CommandLine& line, const char* verb, const char* what) {
  CLI::App& added = add_command(group, line, verb, what, Command::administrate);
  added.callback([&line, text = group.get_name() + " " + verb] {
    line.command = Command::administrate;
    line.administration.verb = text;
  });
  return added;
}

CLI::App& add_group(CLI::App& app, const char* name, const char* what) {
  CLI::App* group = app.add_subcommand(name, what);
  group->require_subcommand(1);
  return *group;
}

void add_user_commands(CLI::App& app, CommandLine& line) {
  CLI::App& group =
      add_group(app, "user", "Users of other machines; dccastd may be running or not");
  AdministrationCommand& asked = line.administration;
  const auto named = [&](const char* verb, const char* what) -> CLI::App& {
    CLI::App& added = add_verb(group, line, verb, what);
    added.add_option("NAME", asked.name, "As jobs name their owner")->required();
    return added;
  };
  named("add", "Add a user, and print the line to hand over")
      .add_option("--role", asked.role, "viewer, submitter or admin")
      ->capture_default_str();
  named("rotate", "Revoke what a user has, and print a new line");
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
  const auto with_names = [&](const char* verb, const char* what) {
    CLI::App& added = add_verb(group, line, verb, what);
    added.add_option("--name", asked.names, "A further name or address of this server")
        ->allow_extra_args(false);
    added.add_option("--days", asked.days, "How long the certificate lasts; as a rule 90");
  };
  with_names("init", "Make them; serve does so by itself at first need");
  with_names("renew", "A new certificate of the same CA, taken up without a restart");
  CLI::App& issue = add_verb(group, line, "issue", "A client certificate in place of a token");
  issue.add_option("NAME", asked.name, "A user")->required();
  issue.add_option("--to", asked.directory, "Where NAME.pem and NAME.key are written")->required();
  issue.add_option("--days", asked.days, "How long it lasts; as a rule 365");
  add_verb(group, line, "show", "Names, validity and fingerprints");
}

void add_audit_command(CLI::App& app, CommandLine& line) {
  AdministrationCommand& asked = line.administration;
  CLI::App& audit = add_command(app, line, "audit", "Who did what, one line of JSON an event",
                                Command::administrate);
  audit.callback([&line] {
    line.command = Command::administrate;
    line.administration.verb = "audit";
  });
  audit.add_option("--user", asked.filter.user, "Only of this user");
  audit.add_option("--job", asked.filter.job, "Only of this job; the beginning of an id will do");
  audit.add_option("--call", asked.filter.call, "Only this call, e.g. SubmitJob");
  audit.add_option("--since", asked.filter.since, "From this time on, e.g. 2026-11-23T08");
}

void add_commands(CLI::App& app, CommandLine& line) {
  app.require_subcommand(0, 1);
  add_worker_policy(
      add_command(app, line, "serve", "Serve; the same as no command", Command::serve),
      line.workers);
  CLI::App& check = add_command(
      app, line, "check", "Inspect the data directory while no dccastd uses it", Command::check);
  check.add_flag("--repair", line.repair, "Put right what can be, and say what was done");
  check.add_flag("--deep", line.deep, "Also hold all results against their SHA-256");
  check.add_option("--adopt", line.adopt, "Take a job back out of quarantine; may be repeated")
      ->type_name("ID")
      ->allow_extra_args(false);
  add_command(app, line, "backup", "Copy the data directory; its dccastd may go on working",
              Command::backup)
      .add_option("--to", line.directory, "A new or empty directory")
      ->required();
  add_command(app, line, "restore", "Make the data directory from a backup, and check it",
              Command::restore)
      .add_option("--from", line.directory, "What dccastd backup wrote")
      ->required();
  add_user_commands(app, line);
  add_pki_commands(app, line);
  add_audit_command(app, line);
}

}  // namespace

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
      "Example: dccastd --config deploy/config/dccastd.toml --set workers=2\n"
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
  return line;
}

}  // namespace dccast::daemon
