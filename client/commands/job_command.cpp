#include "client/commands/job_command.hpp"

#include "client/render/job_text.hpp"

namespace dccast::client::commands {

std::string new_state(const v1::Job& job) {
  return job.id() + " " + render::state_text(job.state()) + "\n";
}

}  // namespace dccast::client::commands
