#include <unistd.h>
#include <csignal>

#include "client/command_line.hpp"

namespace {

/// Leaving never touches a job, and a file being fetched stays as FILE.part: nothing to clean up.
void leave(int) {
  static constexpr char message[] = "\ndccast: interrupted; a job that was submitted goes on\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, message, sizeof message - 1);
  _exit(static_cast<int>(dccast::client::ExitCode::interrupted));
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, leave);
  std::signal(SIGTERM, leave);
  dccast::client::commands::Program program;
  return dccast::client::run_command_line({argv + 1, argv + argc}, program);
}
