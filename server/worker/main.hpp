#pragma once

namespace dccast::worker {

/// The worker program.
///
/// With `--wait` it runs one job: dccastd starts it, with its own process id in the environment,
/// and hands it a WorkerOrder on its standard input, behind its length. Exit codes then:
///   0  the end of the run is in the event log of the job, or there never was a job
///   1  it could not begin: another worker writes into the folder of the job, for example
///  70  the folder of the job is gone, or no daemon came in time and the run did not stop
///  71, 74  jobs::exit_out_of_memory, jobs::exit_storage
/// Once it has claimed the folder of the job it outlives the daemon, as long as the order permits.
/// With `--serve-checks` or `--serve-queries` it answers questions: server/jobs/checker.hpp.
int main(int argc, char** argv);

/// Answers the daemon's questions over a socket until it is closed: see server/jobs/checker.hpp for
/// how they are written. What a question throws becomes its answer. @return the exit code
int serve_checks(int socket);

}  // namespace dccast::worker
