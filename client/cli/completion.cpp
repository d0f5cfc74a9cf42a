#include "client/cli/options.hpp"

#include <algorithm>
#include <initializer_list>

namespace dccast::client {
namespace {

using Commands = std::vector<CommandSummary>;

bool takes(const CommandSummary& command, std::initializer_list<const char*> arguments) {
  return std::any_of(arguments.begin(), arguments.end(), [&](const char* argument) {
    return std::count(command.arguments.begin(), command.arguments.end(), argument) > 0;
  });
}

bool takes_job(const CommandSummary& command) {
  return takes(command, {"JOB", "RUN"});
}

bool takes_file(const CommandSummary& command) {
  return takes(command, {"FILE", "CASE", "RUN"});
}

/// First sentence of a help text, without a long list of choices.
std::string first_sentence(const std::string& text) {
  return text.substr(0, text.find_first_of(".;:"));
}

/// Quotes a text for a shell with single quotes.
std::string single_quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

std::string option_words(const CommandSummary& command) {
  std::string names;
  for (const OptionSummary& option : command.options)
    for (const std::string& name : option.names) names += (names.empty() ? "" : " ") + name;
  return names;
}

// The command is the first word that is no option. `dccast list` gives the ids.
std::string bash_script(const Commands& commands) {
  std::string names, cases;
  for (const CommandSummary& command : commands) {
    names += command.name + " ";
    cases += "    " + command.name + ") words=" + single_quoted(option_words(command)) +
             "; jobs=" + (takes_job(command) ? "1" : "") +
             "; files=" + (takes_file(command) ? "1" : "") + " ;;\n";
  }

  // Ids are asked of the server at each completion; without a server there are none.
  return "# bash completion of dccast\n"
         "_dccast() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} command= word words= jobs= files=\n"
         "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
         "    [[ $word != -* ]] && { command=$word; break; }\n"
         "  done\n"
         "  COMPREPLY=()\n"
         "  case $command in\n"
         "    '') words=" +
         single_quoted(names + "--server --version --help") + " ;;\n" + cases +
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

std::string zsh_options(const CommandSummary& command) {
  std::string lines;
  for (const OptionSummary& option : command.options)
    for (const std::string& name : option.names)
      lines += " " + single_quoted(name + ":" + first_sentence(option.help));
  return lines;
}

std::string zsh_script(const Commands& commands) {
  std::string names, cases;
  for (const CommandSummary& command : commands) {
    names += "    " + single_quoted(command.name + ":" + first_sentence(command.help)) + "\n";
    cases += "    " + command.name + ") options=(" + zsh_options(command) + " )" +
             (takes_job(command) ? "; jobs=1" : "") + (takes_file(command) ? "; files=1" : "") +
             " ;;\n";
  }

  // As for bash: ids are asked of the server at each completion.
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

/// @param line  beginning of each line about the command
std::string fish_option(std::string line, const OptionSummary& option) {
  for (const std::string& name : option.names)
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  return line + (option.takes_value ? " -r" : "") + " -d " +
         single_quoted(first_sentence(option.help)) + "\n";
}

std::string fish_script(const Commands& commands) {
  std::string script = "# fish completion of dccast\ncomplete -c dccast -f\n";
  for (const CommandSummary& command : commands) {
    script += "complete -c dccast -n __fish_use_subcommand -a " + command.name + " -d " +
              single_quoted(first_sentence(command.help)) + "\n";
    const std::string here =
        "complete -c dccast -n '__fish_seen_subcommand_from " + command.name + "'";
    if (takes_job(command)) script += here + " -a '(dccast list --ids 2>/dev/null) last'\n";
    if (takes_file(command)) script += here + " -F\n";
    for (const OptionSummary& option : command.options) script += fish_option(here, option);
  }
  return script;
}

}  // namespace

std::string completion_script(const Commands& commands, const std::string& shell) {
  if (shell == "bash") return bash_script(commands);
  return shell == "zsh" ? zsh_script(commands) : fish_script(commands);
}

}  // namespace dccast::client
