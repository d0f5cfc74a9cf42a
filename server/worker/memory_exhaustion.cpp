#include "server/worker/memory_exhaustion.hpp"

#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <new>

#include "server/jobs/worker_claim.hpp"

namespace dccast::worker {

namespace {

/// A process that cannot map this much more has no memory left to run a step in.
constexpr std::size_t probe_bytes = 64u << 20;

std::atomic<bool> allocation_failed = false;
static_assert(std::atomic<bool>::is_always_lock_free);

void note_failed_allocation() {
  allocation_failed = true;
  throw std::bad_alloc();
}

bool memory_is_exhausted() {
  if (allocation_failed) return true;
  void* probe = ::mmap(nullptr, probe_bytes, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (probe == MAP_FAILED) return true;
  ::munmap(probe, probe_bytes);
  return false;
}

extern "C" void on_crash(int signal) {
  if (memory_is_exhausted()) ::_exit(jobs::exit_out_of_memory);
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

}  // namespace

void name_memory_exhaustion() {
  static std::array<std::byte, 65536> stack;  // of the handler: the crash may be an overflow
  const stack_t alternative{.ss_sp = stack.data(), .ss_flags = 0, .ss_size = stack.size()};
  ::sigaltstack(&alternative, nullptr);
  struct sigaction action {};
  action.sa_handler = on_crash;
  action.sa_flags = SA_ONSTACK | SA_NODEFER;
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT}) ::sigaction(signal, &action, nullptr);
  std::set_new_handler(note_failed_allocation);
}

}  // namespace dccast::worker
