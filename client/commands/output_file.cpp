#include "client/commands/output_file.hpp"

#include "client/failure.hpp"

namespace dccast::client::commands {

void add_force_flag(CLI::App& command, bool& force) {
  command.add_flag("-f,--force", force, "Overwrite a file that is there");
}

void require_free(const std::filesystem::path& file, bool force) {
  std::error_code error;
  // A device or a pipe is there to be written to.
  if (force || !std::filesystem::is_regular_file(file, error)) return;
  throw CommandFailed(
      ExitCode::invalid,
      file.string() + " is there already; give another -o, or --force to overwrite it");
}

}  // namespace dccast::client::commands
