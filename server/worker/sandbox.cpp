#include "server/worker/sandbox.hpp"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <signal.h>
#include <stddef.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <new>
#include <vector>

#include "core/storage/file.hpp"
#include "core/storage/storage_error.hpp"
#include "server/jobs/worker_claim.hpp"

namespace dccast::worker {

namespace {

#if defined(__x86_64__)
constexpr std::uint32_t machine = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t machine = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t machine = 0;  // of no process: every call is permitted
#endif

// Sockets, and what makes them without these calls (io_uring); other programs and processes, and
// what they have.
constexpr std::array refused_calls{SYS_socket,
                                   SYS_connect,
                                   SYS_bind,
                                   SYS_listen,
                                   SYS_accept,
                                   SYS_accept4,
                                   SYS_io_uring_setup,
                                   SYS_execve,
                                   SYS_execveat,
                                   SYS_ptrace,
                                   SYS_process_vm_readv,
                                   SYS_process_vm_writev,
                                   SYS_pidfd_getfd,
                                   SYS_pidfd_send_signal,
                                   SYS_tkill,
                                   SYS_rt_sigqueueinfo,
                                   SYS_rt_tgsigqueueinfo,
                                   SYS_mount,
                                   SYS_unshare,
                                   SYS_setns,
                                   SYS_bpf,
                                   SYS_perf_event_open,
                                   SYS_userfaultfd};
// Permitted to the process itself: abort() and threads need them.
constexpr std::array own_calls{SYS_kill, SYS_tgkill};
// Sanitizers look for leaks and name functions by these.
constexpr std::array sanitizer_calls{SYS_ptrace, SYS_execve};

using Instruction = sock_filter;

constexpr Instruction load(std::size_t offset) {
  return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
}
/// @param steps  over the next instructions where the loaded word is not this
constexpr Instruction skip_unless(std::uint32_t word, std::uint8_t steps) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, word, 0, steps);
}
constexpr Instruction answer(std::uint32_t what) {
  return BPF_STMT(BPF_RET | BPF_K, what);
}

/// The first word of the first argument, on a little-endian machine.
constexpr std::size_t first_argument = offsetof(seccomp_data, args);

std::vector<Instruction> filter() {
  constexpr std::uint32_t refuse = SECCOMP_RET_ERRNO | EPERM;
  std::vector<Instruction> program{
      load(offsetof(seccomp_data, arch)), BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, machine, 1, 0),
      // Calls of another instruction set have other numbers.
      answer(machine == 0 ? SECCOMP_RET_ALLOW : refuse), load(offsetof(seccomp_data, nr))};
#if defined(__x86_64__)
  constexpr std::uint32_t x32_calls = 0x40000000;
  program.insert(program.end(),
                 {BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, x32_calls, 0, 1), answer(refuse)});
#endif
  // New namespaces by clone(); the flags of clone3() lie where no filter reads, and the C library
  // does without it.
  constexpr std::uint32_t namespaces = CLONE_NEWNS | CLONE_NEWCGROUP | CLONE_NEWUTS | CLONE_NEWIPC |
                                       CLONE_NEWUSER | CLONE_NEWPID | CLONE_NEWNET;
  program.insert(program.end(), {skip_unless(SYS_clone3, 1), answer(SECCOMP_RET_ERRNO | ENOSYS),
                                 skip_unless(SYS_clone, 4), load(first_argument),
                                 BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, namespaces, 0, 1),
                                 answer(refuse), answer(SECCOMP_RET_ALLOW)});
  for (const long call : refused_calls)
    if (!sanitized || std::ranges::find(sanitizer_calls, call) == sanitizer_calls.end())
      program.insert(program.end(),
                     {skip_unless(static_cast<std::uint32_t>(call), 1), answer(refuse)});
  for (const long call : own_calls)
    program.insert(program.end(),
                   {skip_unless(static_cast<std::uint32_t>(call), 4), load(first_argument),
                    skip_unless(static_cast<std::uint32_t>(::getpid()), 1),
                    answer(SECCOMP_RET_ALLOW), answer(refuse)});
  program.push_back(answer(SECCOMP_RET_ALLOW));
  return program;
}

std::string lacking(const char* what, const char* of) {
  return std::string(what) + " (" + of + ": " + ::strerror(errno) + ")";
}

// Debian 12's headers end at version 2 of Landlock; the numbers are the kernel's
// (include/uapi/linux/landlock.h of Linux 6.12).
struct Ruleset {
  std::uint64_t files = 0, network = 0, scope = 0;
};
constexpr std::uint64_t truncate = 1u << 14;             // version 3
constexpr std::uint64_t tcp = (1u << 0) | (1u << 1);     // version 4: bind, connect
constexpr std::uint64_t others = (1u << 0) | (1u << 1);  // version 6: abstract sockets, signals

/// Everything that changes a file system, as far as a version of Landlock knows it.
constexpr std::uint64_t writing(long version) {
  std::uint64_t writes = 0;
  for (const std::uint64_t one :
       {LANDLOCK_ACCESS_FS_WRITE_FILE, LANDLOCK_ACCESS_FS_REMOVE_DIR,
        LANDLOCK_ACCESS_FS_REMOVE_FILE, LANDLOCK_ACCESS_FS_MAKE_CHAR, LANDLOCK_ACCESS_FS_MAKE_DIR,
        LANDLOCK_ACCESS_FS_MAKE_REG, LANDLOCK_ACCESS_FS_MAKE_SOCK, LANDLOCK_ACCESS_FS_MAKE_FIFO,
        LANDLOCK_ACCESS_FS_MAKE_BLOCK, LANDLOCK_ACCESS_FS_MAKE_SYM})
    writes |= one;
  if (version >= 2) writes |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= 3) writes |= truncate;
  return writes;
}

/// @return 0, or -1 and errno
long restrict_writing(long version, const std::filesystem::path& folder) {
  const Ruleset rules{.files = writing(version),
                      .network = version >= 4 ? tcp : 0,
                      .scope = version >= 6 ? others : 0};
  // A kernel takes no field that it does not know.
  const std::size_t size = (version >= 6 ? 3 : version >= 4 ? 2 : 1) * sizeof(std::uint64_t);
  const storage::FileDescriptor ruleset(
      static_cast<int>(::syscall(SYS_landlock_create_ruleset, &rules, size, 0)));
  if (!ruleset) return -1;
  if (!folder.empty()) {
    const storage::FileDescriptor beneath(::open(folder.c_str(), O_PATH | O_CLOEXEC));
    if (!beneath) return -1;
    const landlock_path_beneath_attr rule{.allowed_access = rules.files,
                                          .parent_fd = beneath.get()};
    if (::syscall(SYS_landlock_add_rule, ruleset.get(), LANDLOCK_RULE_PATH_BENEATH, &rule, 0) != 0)
      return -1;
  }
  return ::syscall(SYS_landlock_restrict_self, ruleset.get(), 0);
}

std::int64_t most_of_memory() {
  return static_cast<std::int64_t>(::sysconf(_SC_PHYS_PAGES)) * ::sysconf(_SC_PAGESIZE) / 10 * 9;
}

/// Lowers a limit; never above one that is there. @return the limit in force
rlim_t limit(__rlimit_resource resource, std::int64_t most) {
  rlimit now{};
  ::getrlimit(resource, &now);
  const rlim_t least = std::min<rlim_t>(static_cast<rlim_t>(most), now.rlim_max);
  const rlimit lower{least, least};
  return ::setrlimit(resource, &lower) == 0 ? least : now.rlim_cur;
}

std::string in_megabytes(const char* what, rlim_t bytes) {
  return what + (bytes == RLIM_INFINITY
                     ? std::string(" of any size")
                     : " up to " + storage::megabytes(static_cast<std::int64_t>(bytes)));
}

std::atomic<bool> file_bound_met = false;
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void note_file_bound(int) {
  file_bound_met = true;
}

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

std::string isolate() {
  limit(RLIMIT_CORE, 0);
  if (!sanitized) ::prctl(PR_SET_DUMPABLE, 0);  // nor read by other processes of its user
  std::vector<Instruction> program = filter();
  const sock_fprog whole{static_cast<unsigned short>(program.size()), program.data()};
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return lacking("may gain privileges", "prctl");
  if (::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &whole) != 0)
    return lacking("may use the network", "seccomp");
  return "no network, no other processes (seccomp)";
}

std::string confine_writing_to(const std::filesystem::path& folder) {
  const long version =
      ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  const char* anywhere = "writes where its user may";
  if (version < 0) return lacking(anywhere, "Landlock");
  if (restrict_writing(version, folder) != 0) return lacking(anywhere, "Landlock");
  return (folder.empty() ? std::string("writes no file")
                         : "writes only beneath " + folder.string()) +
         " (Landlock " + std::to_string(version) + ")";
}

std::string bound(const Bounds& bounds) {
  const std::int64_t memory = bounds.memory_bytes > 0 ? bounds.memory_bytes : most_of_memory();
  std::string text = sanitized ? "memory without a bound (sanitizer)"
                               : in_megabytes("memory", limit(RLIMIT_DATA, memory));
  if (bounds.file_bytes <= 0) return text;
  ::signal(SIGXFSZ, note_file_bound);  // the write is an error, too
  return text + in_megabytes(", files", limit(RLIMIT_FSIZE, bounds.file_bytes));
}

bool met_file_bound() {
  return file_bound_met;
}

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
