#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "server/jobs/processes.hpp"

namespace dccast::worker {

/// Sanitizers map more memory than any machine has, look for leaks from a second process and name
/// functions by another program: their builds have no bound of memory, ptrace and execve.
using jobs::sanitized;

/// What a worker gives up before it reads anything that came from outside, so that a mesh or a
/// result file that takes it over reaches no more than the worker's own folder. Each step holds for
/// the process from then on, and cannot be taken back; docs/sandbox.md has the whole.

/// No sockets, no signals to other processes, no look into them and no change of their limits and
/// priorities, no memory that bound() does not count, no new privileges, no core dumps. @return
/// what is in force, for logs, e.g. "no network, no signals to others (seccomp)"; what the kernel
/// lacks is named, too
std::string isolate();

/// No writing outside of a folder. A worker is confined once, for its job or for its answers.
/// @param folder  empty: nowhere  @return as isolate()
std::string confine_writing_to(const std::filesystem::path& folder);

/// What a job may take; 0: nine tenths of the machine's memory, files of any size.
struct Bounds {
  std::int64_t memory_bytes = 0;  ///< of data, not of the program and its libraries
  std::int64_t file_bytes = 0;    ///< of each file
};
/// Memory or a file beyond its bound is an error of the call that asked for it.
/// @return as isolate(): "memory up to 8000 MB, files up to 100000 MB"
std::string bound(const Bounds& bounds);
/// Whether a file was to become larger than bound() permits.
bool met_file_bound();

/// From now on this process ends with jobs::exit_out_of_memory when a crash (SIGSEGV, SIGBUS,
/// SIGABRT) follows from memory that it could not get: a library that does not check malloc(), a
/// second failure while the first one is reported. Other crashes stay what they are.
void name_memory_exhaustion();

}  // namespace dccast::worker
