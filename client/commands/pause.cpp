#include "client/commands/job_command.hpp"

namespace dccast::client::commands {

void add_pause(CLI::App& app, Program& program) {
  add_job_command(
      app, program,
      {"pause", "Stop a job at a checkpoint and keep it out of the queue", "dccast pause JOB"},
      &Stub::PauseJob, std::make_shared<v1::PauseJobRequest>());
}

}  // namespace dccast::client::commands
