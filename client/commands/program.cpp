#include <iostream>

#include "client/cli/completion.hpp"
#include "client/commands/commands.hpp"
#include "client/model/json.hpp"
#include "client/text/table.hpp"

namespace dccast::client::commands {
namespace {

struct InfoOptions {
  bool json = false;
};

/// Limits of this daemon; empty for a daemon that does not report them.
std::string ceilings_text(const v1::GetServerInfoResponse& info) {
  constexpr double bytes_of_a_megabyte = 1e6;
  if (info.maximum_nodes() <= 0) return {};
  return "ceilings " + std::to_string(info.maximum_nodes()) + " nodes, " +
         std::to_string(info.maximum_steps()) + " steps, " +
         render::fixed(info.maximum_memory_bytes() / bytes_of_a_megabyte, 0) +
         " MB of memory for one case\n";
}

ExitCode run(const InfoOptions& options, Program& program) {
  Connection connection = program.connect();
  const auto info = connection.call(&Stub::GetServerInfo, v1::GetServerInfoRequest());
  if (options.json) {
    std::cout << to_json(info).dump() << '\n';
    return ExitCode::done;
  }
  std::cout << "server   " << connection.server() << "\nversion  " << info.version()
            << "\nworkers  " << info.workers() << "\nrunning  " << info.running() << "\nqueued   "
            << info.queued() << " of at most " << info.maximum_queued() << "\npaused   "
            << info.paused() << "\nlargest  " << info.maximum_message_bytes()
            << " bytes of case and attachments\n"
            << ceilings_text(info) << "build    " << info.build() << '\n';
  if (!info.storage_fault().empty())
    std::cout << "held     " << info.storage_fault() << "; no job starts until this is fixed\n";
  if (info.quarantined() > 0)
    std::cout << "aside    " << info.quarantined()
              << " folders without a job; `dccastd check` lists them\n";
  return ExitCode::done;
}

constexpr const char* completion_examples =
    "dccast completion bash > ~/.local/share/bash-completion/completions/dccast\n"
    "  dccast completion zsh > \"${fpath[1]}/_dccast\"\n"
    "  dccast completion fish > ~/.config/fish/completions/dccast.fish";

}  // namespace

void add_info(cli::CommandLine& line, Program& program) {
  const auto options = std::make_shared<InfoOptions>();
  const cli::Command command =
      line.command("info", "What the server is and how busy it is", "dccast info --json");
  command.json(options->json);
  command.action([options, &program] { return run(*options, program); });
}

void add_completion(cli::CommandLine& line, Program&) {
  const auto shell = std::make_shared<std::string>();
  const cli::Command command = line.command(
      "completion", "Print a script for shell completion of dccast", completion_examples);
  command.option("SHELL", *shell, "bash, zsh or fish").required().one_of({"bash", "zsh", "fish"});
  command.action([shell, &line] {
    std::cout << completion_script(line.commands(), *shell);
    return ExitCode::done;
  });
}

}  // namespace dccast::client::commands
