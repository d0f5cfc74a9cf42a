#pragma once

namespace dccast::worker {

/// Answers the daemon's questions over a socket until it is closed: server/jobs/checker.hpp says
/// how they are written. What a question throws becomes its answer. @return the exit code
int serve_checks(int socket);

}  // namespace dccast::worker
