#include "client/session/user_command.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <iostream>
#include <vector>

namespace dccast::client {

namespace {

/// The environment of this process with the facts in it, without changing that of other threads.
std::vector<std::string> environment_with(const std::map<std::string, std::string>& facts) {
  std::vector<std::string> variables;
  for (const auto& [name, value] : facts) variables.push_back(name + "=" + value);
  for (char** variable = environ; *variable; ++variable) {
    const std::string text = *variable;
    if (!facts.contains(text.substr(0, text.find('=')))) variables.push_back(text);
  }
  return variables;
}

void report(const std::string& fault) {
  std::cerr << fmt::format("dccast: the command of --notify {}\n", fault);
}

}  // namespace

void run_user_command(const std::string& command, const std::map<std::string, std::string>& facts) {
  std::vector<std::string> variables = environment_with(facts);
  std::vector<char*> environment;
  for (std::string& variable : variables) environment.push_back(variable.data());
  environment.push_back(nullptr);

  // Facts pass in the environment, where no quoting of a shell can change them.
  std::string shell = "sh", option = "-c", text = command;
  std::array<char*, 4> arguments{shell.data(), option.data(), text.data(), nullptr};
  pid_t child = 0;
  const int error =
      ::posix_spawn(&child, "/bin/sh", nullptr, nullptr, arguments.data(), environment.data());
  if (error != 0) return report(fmt::format("cannot be run: {}", std::strerror(error)));

  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (status != 0) report(fmt::format("ended with status {}", status));
}

}  // namespace dccast::client
