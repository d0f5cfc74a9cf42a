#pragma once

namespace dccast::client {

/// Exit codes of every program of the project.
enum class ExitCode {
  done = 0,
  invalid = 2,       ///< usage, or a case with faults; with --strict one with findings
  solve_failed = 3,  ///< the job ended without success; with --strict one with findings
  unreachable = 4,   ///< the server does not answer, or refused
  not_found = 5,     ///< no such thing, or not allowed
  wrong_state = 6,   ///< not in the state that the thing is in now
  interrupted = 130  ///< by SIGINT (Ctrl-C) or SIGTERM
};

}  // namespace dccast::client
