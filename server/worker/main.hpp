#pragma once

namespace dccast::worker {

/// The worker program.
///
/// With `--wait` it runs one job: dccastd starts it, tells it in the environment where to call
/// (DCCAST_WORKER_LINK) and whose child it is (_PARENT), and, once there is a job for it, on the
/// standard input its id, its token and the file for what it says, a line each.
///   0  the daemon has what the run ended with        70  the daemon is gone
/// With `--check` it reads a serialised WorkerOrder.Start from its standard input and writes the
/// ValidateCaseResponse of its case; with `--frame` the last Frame of the results in its directory.
///   0  answered                                      1  said on standard error why not
int main(int argc, char** argv);

}  // namespace dccast::worker
