#pragma once

namespace dccast::worker {

/// The worker program.
///
/// With `--wait` it runs one job: dccastd starts it, tells it in the environment where to call
/// (DCCAST_WORKER_LINK) and whose child it is (_PARENT), and, once there is a job for it, on the
/// standard input its id, its token and the file for what it says, a line each.
///   0  the daemon has what the run ended with        70  the daemon is gone
/// With `--serve-checks` or `--serve-queries` it answers questions about cases and results on the
/// socket that is its standard input, see server/jobs/checker.hpp.
///   0  the daemon has closed the socket              1  the socket broke in the middle of a
///   question
int main(int argc, char** argv);

}  // namespace dccast::worker
