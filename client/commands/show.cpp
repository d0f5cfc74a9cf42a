#include "client/commands/job_command.hpp"
#include "client/render/job_text.hpp"

namespace dccast::client::commands {

void add_show(CLI::App& app, Program& program) {
  add_job_command(app, program, {"show", "Everything about one job", "dccast show JOB"},
                  &Stub::GetJob, std::make_shared<v1::GetJobRequest>(), render::job_sheet);
}

}  // namespace dccast::client::commands
