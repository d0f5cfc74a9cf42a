#include "client/commands/job_command.hpp"
#include "proto/values/shortened.hpp"

namespace dccast::client::commands {

void add_cancel(CLI::App& app, Program& program) {
  const auto request = std::make_shared<v1::CancelJobRequest>();
  CLI::App* const command =
      add_job_command(app, program,
                      {"cancel", "Stop a job permanently; a job that has ended is not changed",
                       "dccast cancel JOB --reason \"wrong alloy\""},
                      &Stub::CancelJob, request);
  command->add_option("--reason", *request->mutable_reason(), "Kept with the job")
      ->check([](const std::string& text) { return values::too_long("the reason", text); });
}

}  // namespace dccast::client::commands
