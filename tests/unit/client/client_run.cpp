#include "client_run.hpp"

#include <gtest/gtest.h>

#include "client/commands/commands.hpp"

namespace dccast::client {

Result dccast(std::vector<std::string> arguments, const std::string& server,
              const std::filesystem::path& configuration) {
  Program program;
  program.server = server;
  program.configuration = configuration;
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int code = run_command_line(std::move(arguments), program);
  std::string out = testing::internal::GetCapturedStdout();
  return {code, out, testing::internal::GetCapturedStderr()};
}

}  // namespace dccast::client
