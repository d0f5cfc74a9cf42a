#include "client/completion.hpp"

#include <vector>

namespace dccast::client {
namespace {

struct OptionWords {
  std::vector<std::string> names;  ///< "-w", "--watch"
  std::string help;                ///< its first sentence
  bool takes_value = false;
};

struct CommandWords {
  std::string name, help;
  std::vector<OptionWords> options;
  bool takes_job = false;
  bool takes_file = false;
};

/// Truncates a long list of choices.
std::string first_sentence(const std::string& text) {
  return text.substr(0, text.find_first_of(".;:"));
}

OptionWords words_of(const CLI::Option& option) {
  OptionWords words{
      {}, first_sentence(option.get_description()), option.get_items_expected_max() > 0};
  for (const std::string& name : option.get_snames()) words.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) words.names.push_back("--" + name);
  return words;
}

CommandWords words_of(const CLI::App& command) {
  CommandWords words{command.get_name(), first_sentence(command.get_description()), {}};
  for (const CLI::Option* const option : command.get_options()) {
    const std::string position = option->get_name(true);
    words.takes_job = words.takes_job || position == "JOB" || position == "RUN";
    words.takes_file =
        words.takes_file || position == "FILE" || position == "CASE" || position == "RUN";
    if (option->nonpositional()) words.options.push_back(words_of(*option));
  }
  return words;
}

std::vector<CommandWords> commands_of(const CLI::App& app) {
  std::vector<CommandWords> commands;
  for (const CLI::App* const command : app.get_subcommands({}))
    commands.push_back(words_of(*command));
  return commands;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

/// In single quotes of a shell.
std::string single_quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

std::string option_names(const CommandWords& command) {
  std::vector<std::string> names;
  for (const OptionWords& option : command.options)
    names.insert(names.end(), option.names.begin(), option.names.end());
  return joined(names);
}

std::string command_names(const std::vector<CommandWords>& commands) {
  std::vector<std::string> names;
  for (const CommandWords& command : commands) names.push_back(command.name);
  return joined(names);
}

// The command is the first word that is no option; `dccast list` is asked for the ids.
std::string bash_script(const std::vector<CommandWords>& commands) {
  std::string cases;
  for (const CommandWords& command : commands)
    cases += "    " + command.name + ") words=" + single_quoted(option_names(command)) +
             "; jobs=" + (command.takes_job ? "1" : "") +
             "; files=" + (command.takes_file ? "1" : "") + " ;;\n";
  return "# bash completion of dccast\n"
         "_dccast() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} command= word words= jobs= files=\n"
         "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
         "    [[ $word != -* ]] && { command=$word; break; }\n"
         "  done\n"
         "  COMPREPLY=()\n"
         "  case $command in\n"
         "    '') words=" +
         single_quoted(command_names(commands) + " --server --version --help") + " ;;\n" + cases +
         "  esac\n"
         "  if [[ -n $jobs && $current != -* ]]; then\n"
         "    words+=\" last $(dccast list --ids 2>/dev/null)\"\n"
         "  fi\n"
         "  COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "  if [[ ${COMP_WORDS[COMP_CWORD-1]} == -o || -n $files && $current != -* ]]; then\n"
         "    COMPREPLY+=($(compgen -f -- \"$current\"))\n"
         "  fi\n"
         "}\n"
         "complete -o filenames -F _dccast dccast\n";
}

std::string zsh_options(const CommandWords& command) {
  std::string lines;
  for (const OptionWords& option : command.options)
    for (const std::string& name : option.names)
      lines += " " + single_quoted(name + ":" + option.help);
  return lines;
}

std::string zsh_script(const std::vector<CommandWords>& commands) {
  std::string names, cases;
  for (const CommandWords& command : commands) {
    names += "    " + single_quoted(command.name + ":" + command.help) + "\n";
    cases += "    " + command.name + ") options=(" + zsh_options(command) + " )" +
             (command.takes_job ? "; jobs=1" : "") + (command.takes_file ? "; files=1" : "") +
             " ;;\n";
  }
  return "#compdef dccast\n"
         "_dccast() {\n"
         "  local -a commands options ids\n"
         "  local command= word jobs= files=\n"
         "  commands=(\n" +
         names +
         "  )\n"
         "  for word in ${words[2,CURRENT-1]}; do\n"
         "    [[ $word != -* ]] && { command=$word; break }\n"
         "  done\n"
         "  case $command in\n"
         "    '') _describe command commands; return ;;\n" +
         cases +
         "  esac\n"
         "  if [[ $PREFIX == -* ]]; then\n"
         "    _describe option options\n"
         "    return\n"
         "  fi\n"
         "  if [[ -n $jobs ]]; then\n"
         "    ids=(last ${(f)\"$(dccast list --ids 2>/dev/null)\"})\n"
         "    compadd -a ids\n"
         "  fi\n"
         "  [[ -n $files || $words[CURRENT-1] == -o ]] && _files\n"
         "}\n"
         "if [[ $funcstack[1] == _dccast ]]; then _dccast \"$@\"; else compdef _dccast dccast; "
         "fi\n";
}

std::string fish_option(const CommandWords& command, const OptionWords& option) {
  std::string line = "complete -c dccast -n '__fish_seen_subcommand_from " + command.name + "'";
  for (const std::string& name : option.names)
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  return line + (option.takes_value ? " -r" : "") + " -d " + single_quoted(option.help) + "\n";
}

std::string fish_script(const std::vector<CommandWords>& commands) {
  std::string script = "# fish completion of dccast\ncomplete -c dccast -f\n";
  for (const CommandWords& command : commands) {
    script += "complete -c dccast -n __fish_use_subcommand -a " + command.name + " -d " +
              single_quoted(command.help) + "\n";
    const std::string here =
        "complete -c dccast -n '__fish_seen_subcommand_from " + command.name + "'";
    if (command.takes_job) script += here + " -a '(dccast list --ids 2>/dev/null) last'\n";
    if (command.takes_file) script += here + " -F\n";
    for (const OptionWords& option : command.options) script += fish_option(command, option);
  }
  return script;
}

}  // namespace

std::string completion_script(const CLI::App& app, const std::string& shell) {
  const auto commands = commands_of(app);
  if (shell == "bash") return bash_script(commands);
  return shell == "zsh" ? zsh_script(commands) : fish_script(commands);
}

}  // namespace dccast::client
