#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "server/jobs/processes.hpp"

namespace dccast::worker {

/// Sanitizers map more memory than any machine has, search for leaks from a second process and run
/// another program to name functions: their builds do not limit memory, ptrace and execve.
using jobs::sanitized;

/// The rights that a worker gives up before it reads foreign files, so that a mesh or a result file
/// that takes control of it reaches only the worker's own folder. A right that was given up cannot
/// be regained. docs/sandbox.md describes the whole.

/// Forbids sockets, signals to other processes, their inspection, changes of their limits and
/// priorities, memory that bound() does not count, new privileges and core dumps.
/// @return what is in force, for logs, e.g. "no network, no signals to others (seccomp)", and what
/// the kernel lacks
std::string isolate();

/// The folders that a worker still reaches; what lies elsewhere it reads only as part of its
/// program.
struct Reach {
  std::filesystem::path own{};       ///< it reads and writes here; empty: it writes nowhere
  std::filesystem::path readable{};  ///< it reads here, too; empty: none
};

/// Forbids files elsewhere, and locks on all files. A worker is confined once, for its job or for
/// its answers, and takes the lock that it needs before. @return as isolate()
std::string confine_to(const Reach& reach);

/// Limits of a job; 0: nine tenths of the machine's memory, files of any size.
struct Bounds {
  std::int64_t memory_bytes = 0;  ///< data, without the program and its libraries
  std::int64_t file_bytes = 0;    ///< size of each file
};
/// Sets limits: a call that asks for memory or file size beyond its limit fails.
/// @return as isolate(): "memory up to 8000 MB, files up to 100000 MB"
std::string bound(const Bounds& bounds);
/// Whether a write has failed because of the limit of a file.
bool met_file_bound();

/// Makes this process end with jobs::exit_out_of_memory if a crash (SIGSEGV, SIGBUS, SIGABRT)
/// follows from lack of memory: a library that does not check malloc(), or a second failure while
/// the first one is reported. Other crashes are not changed.
void name_memory_exhaustion();

}  // namespace dccast::worker
