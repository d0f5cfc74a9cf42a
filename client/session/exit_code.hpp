#pragma once

namespace dccast::client {

/// Exit codes of every program of the project.
enum class ExitCode {
  done = 0,
  invalid = 2,       ///< usage error, or a case with faults; with --strict also findings
  solve_failed = 3,  ///< the job did not succeed; with --strict also findings
  unreachable = 4,   ///< the server does not answer, or refuses
  not_found = 5,     ///< does not exist, or not allowed
  wrong_state = 6,   ///< not possible in the present state of the object
  interrupted = 130  ///< by SIGINT (Ctrl-C) or SIGTERM
};

}  // namespace dccast::client
