#include "client/case_options.hpp"

#include "client/failure.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::client {

CLI::Option* add_set_option(CLI::App& command, std::vector<std::string>& changes) {
  return command
      .add_option("--set", changes,
                  "Change one key of the case, e.g. --set mesh.rows=30, "
                  "--set schedule.hold=\"5 s\" or --set schedule.water_flow.scale=\"0.8 until 100 "
                  "mm\"; may be given several times")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false)
      ->check([](const std::string& text) {
        return case_file::parse_change(text) ? std::string()
                                             : "'" + text + "' is not KEY=VALUE, e.g. mesh.rows=30";
      });
}

std::vector<v1::CaseChange> changes_of(const std::vector<std::string>& texts) {
  std::vector<v1::CaseChange> changes;
  for (const std::string& text : texts)
    if (auto change = case_file::parse_change(text)) changes.push_back(std::move(*change));
  return changes;
}

double metres_of(const std::string& text, const char* option) {
  const case_file::Quantity quantity = case_file::parse_quantity(text, "m");
  if (!quantity.value)
    throw CommandFailed(ExitCode::invalid, std::string(option) + " \"" + text + "\": " +
                                               quantity.message + ", for example \"285 mm\"");
  return *quantity.value;
}

}  // namespace dccast::client
