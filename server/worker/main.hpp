#pragma once

namespace dccast::worker {

/// The worker program.
///
/// With `--wait` it runs one job: dccastd starts it, tells it in the environment where to call
/// (DCCAST_WORKER_LINK) and whose child it is (_PARENT), and, once there is a job for it, on the
/// standard input its id, its token and the file for what it says, a line each.
///   0  the daemon has what the run ended with
///   1  it could not begin: another worker writes into the folder of the job, say
///  70  the daemon is gone, or refuses this worker
/// Once it has claimed the folder of the job it outlives the daemon, as long as the daemon has said
/// that it should, and goes on with the next one: docs/operations.md.
/// With `--serve-checks` or `--serve-queries` it answers questions about cases and results on the
/// socket that is its standard input, see server/jobs/checker.hpp.
///   0  the daemon has closed the socket              1  the socket broke in the middle of a
///   question
int main(int argc, char** argv);

}  // namespace dccast::worker
