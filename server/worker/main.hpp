#pragma once

namespace dccast::worker {

/// The worker program.
///
/// Without arguments it runs one job: dccastd starts it, tells it in the environment where to call
/// (DCCAST_WORKER_LINK) and as whom (_JOB, _TOKEN), and whose child it is (_PARENT).
///   0  the daemon has what the run ended with        70  the daemon is gone
/// With `--check` it reads a serialised WorkerOrder.Start from its standard input and writes the
/// ValidateCaseResponse of its case; with `--frame` the last Frame of the results in its directory.
///   0  answered                                      1  said on standard error why not
int main(int argc, char** argv);

}  // namespace dccast::worker
