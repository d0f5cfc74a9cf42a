#pragma once

namespace dccast::worker {

/// From now on this process ends with jobs::exit_out_of_memory when a crash (SIGSEGV, SIGBUS,
/// SIGABRT) follows from memory that it could not get: a library that does not check malloc(), a
/// second failure while the first one is reported. Other crashes stay what they are.
void name_memory_exhaustion();

}  // namespace dccast::worker
