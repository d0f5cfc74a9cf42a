#include "client/commands/job_command.hpp"

namespace dccast::client::commands {

void add_resume(CLI::App& app, Program& program) {
  add_job_command(app, program,
                  {"resume", "Put a paused job back into the queue", "dccast resume JOB", false},
                  &Stub::ResumeJob, std::make_shared<v1::ResumeJobRequest>());
}

}  // namespace dccast::client::commands
