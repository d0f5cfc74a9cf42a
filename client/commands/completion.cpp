#include "client/completion.hpp"

#include <iostream>

#include "client/commands/commands.hpp"

namespace dccast::client::commands {
namespace {

constexpr const char* examples =
    "dccast completion bash > ~/.local/share/bash-completion/completions/dccast\n"
    "  dccast completion zsh > \"${fpath[1]}/_dccast\"\n"
    "  dccast completion fish > ~/.config/fish/completions/dccast.fish";

}  // namespace

void add_completion(CLI::App& app, Program& program) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* const command =
      subcommand(app, "completion", "Print a script for shell completion of dccast", examples);
  command->add_option("SHELL", *shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command->callback([shell, &app, &program] {
    program.action = [shell, &app] {
      std::cout << completion_script(app, *shell);
      return ExitCode::done;
    };
  });
}

}  // namespace dccast::client::commands
