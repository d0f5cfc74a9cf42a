#include "client/commands/output_file.hpp"

#include <fstream>
#include <iostream>

#include "client/failure.hpp"

namespace dccast::client::commands {

void add_force_flag(CLI::App& command, bool& force) {
  command.add_flag("-f,--force", force, "Overwrite an existing file");
}

void require_free(const std::filesystem::path& file, bool force) {
  std::error_code error;
  // Devices and pipes may always be written to.
  if (force || !std::filesystem::is_regular_file(file, error)) return;
  throw CommandFailed(
      ExitCode::invalid,
      file.string() + " exists already; give another -o, or --force to overwrite it");
}

void write_output(const std::string& path, const std::string& content) {
  if (path == "-") {
    std::cout << content << std::flush;
    return;
  }
  std::ofstream stream(path, std::ios::binary);
  if (!(stream << content << std::flush))
    throw CommandFailed(ExitCode::not_found, "cannot write " + path);
  std::cerr << "wrote " << path << '\n';
}

}  // namespace dccast::client::commands
