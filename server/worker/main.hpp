#pragma once

#include "dccast/v1/worker.pb.h"

namespace dccast::worker {

/// The worker program. dccastd starts it, with its own process id in the environment, and sends it
/// requests on its standard input: worker.proto. As `dccast-worker --run FOLDER ATTEMPT` it runs
/// the job whose order lies in a folder (server/jobs/worker_claim.hpp), without a daemon. Exit
/// codes:
///   0  the daemon has closed the link, or the end of the run is in the event log of the job
///   1  it could not begin: another worker writes into the folder of the job, for example
///  70  the folder of the job is gone, a later start of the job has it, or no daemon
///     came in time and the run did not stop
///  75  the attempt has begun before
///  71, 74  jobs::exit_out_of_memory, jobs::exit_storage
/// Once it has claimed the folder of a job it outlives the daemon, as long as the order permits.
int main(int argc, char** argv);

// In answers.cpp.

/// Answers a request that is not the run of a job. What it throws becomes its answer.
/// @param socket  where the events of a run go
v1::WorkerAnswer answer(const v1::WorkerRequest& request, int socket);
/// @return whether the daemon takes it
bool send_answer(int socket, const v1::WorkerAnswer& answer);

inline constexpr int exit_link_broken = 1;

}  // namespace dccast::worker
