#include "client/cli/common_options.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>

#include "client/session/failure.hpp"
#include "client/text/study_text.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::client {

void add_set_option(const Command& command, std::vector<std::string>& changes,
                    const std::string& help) {
  const auto fault = [](const std::string& text) {
    return case_file::parse_change(text) ? std::string()
                                         : "'" + text + "' is not KEY=VALUE, e.g. mesh.rows=30";
  };
  command.repeatable("--set", changes, help, {.fault = fault, .placeholder = "KEY=VALUE"});
}

void add_columns_option(const Command& command, std::string& file) {
  command.option("--columns", file,
                 "TOML file with the plant's names and units of the columns (docs/plc.md)",
                 {.placeholder = "FILE"});
}

void add_force_flag(const Command& command, bool& force) {
  command.flag("-f,--force", force, "Overwrite an existing file");
}

void add_study_options(const Command& command, StudyOptions& options,
                       const StudyOptionTexts& texts) {
  add_set_option(command, options.base.set);
  command.option("--label", options.base.labels, "Label of the study; repeatable");
  command.option("--study", options.study, texts.study);
  command.flag("--no-wait", options.no_wait, "Do not wait for the runs to end");
  command.option("--plot", options.plot, texts.plot);
  add_force_flag(command, options.force);
  command.json(options.json, texts.json);
}

void follow_with_progress(Connection& connection, const std::string& id,
                          const std::string& come_back) {
  try {
    StudyProgress progress(std::cerr, terminal_of(2));
    follow_study(
        connection, id, [&](const v1::Study& study) { progress.show(study); }, std::cerr);
  } catch (const Interrupted&) {
    throw Interrupted("the study goes on. Come back: " + come_back);
  }
}

double metres_of(const std::string& text, const char* option) {
  const case_file::Quantity quantity = case_file::parse_quantity(text, "m");
  if (!quantity.value)
    throw invalid(std::string(option) + " \"" + text + "\": " + quantity.message +
                  ", for example \"285 mm\"");
  return *quantity.value;
}

void require_free(const std::filesystem::path& file, bool force) {
  std::error_code error;
  // Devices and pipes can always be overwritten.
  if (force || file.empty() || file == "-" || !std::filesystem::is_regular_file(file, error))
    return;
  throw invalid(file.string() + " exists already; give another -o, or --force to overwrite it");
}

void write_file(const std::filesystem::path& file, const std::string& content) {
  std::ofstream stream(file, std::ios::binary);
  if (stream << content << std::flush) return;
  const std::string reason = std::strerror(errno);
  std::error_code error;
  if (stream.is_open() && std::filesystem::is_regular_file(file, error))
    std::filesystem::remove(file, error);
  throw CommandFailed(ExitCode::output_lost, "cannot write " + file.string() + ": " + reason);
}

void write_output(const std::string& path, const std::string& content) {
  if (path == "-") {
    std::cout << content << std::flush;
    return;
  }
  write_file(path, content);
  std::cerr << "wrote " << path << '\n';
}

}  // namespace dccast::client
