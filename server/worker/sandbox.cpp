#include "server/worker/sandbox.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <linux/audit.h>
#include <linux/capability.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <linux/sockios.h>
#include <sched.h>
#include <signal.h>
#include <stddef.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <new>
#include <span>
#include <vector>

#include "core/storage/file.hpp"
#include "core/storage/storage_error.hpp"
#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/processes.hpp"

namespace dccast::worker {

namespace {

#if defined(__x86_64__)
constexpr std::uint32_t machine = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t machine = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t machine = 0;  // of no process: every call is permitted
#endif

// Refused calls: sockets and their substitutes (io_uring); other programs and processes and their
// resources; memory that belongs to no process, which no limit of a process counts.
constexpr std::array refused_calls{SYS_socket,
                                   SYS_socketpair,
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
                                   SYS_process_madvise,
                                   SYS_process_mrelease,
                                   SYS_migrate_pages,
                                   SYS_move_pages,
                                   SYS_kcmp,
                                   SYS_pidfd_getfd,
                                   SYS_pidfd_send_signal,
                                   SYS_tkill,
                                   SYS_rt_sigqueueinfo,
                                   SYS_rt_tgsigqueueinfo,
                                   SYS_ioprio_set,
                                   SYS_memfd_create,
                                   SYS_memfd_secret,
                                   SYS_shmget,
                                   SYS_shmat,
                                   SYS_mount,
                                   SYS_unshare,
                                   SYS_setns,
                                   SYS_bpf,
                                   SYS_perf_event_open,
                                   SYS_userfaultfd};
// Their first argument is a process, which must be this one: abort() and threads need the signals.
constexpr std::array signal_calls{SYS_kill, SYS_tgkill};
// The same, where 0 is the caller.
constexpr std::array own_process_calls{SYS_prlimit64, SYS_sched_setaffinity, SYS_sched_setscheduler,
                                       SYS_sched_setparam, SYS_sched_setattr};
// Sanitizers use these calls to find leaks and to name functions.
constexpr std::array sanitizer_calls{SYS_ptrace, SYS_execve, SYS_socketpair};

// Have the kernel send another process a signal, any one of them; a lease makes another process
// that opens the file wait for us.
constexpr std::array<std::uint32_t, 5> refused_file_controls{F_SETOWN, F_SETSIG, F_SETOWN_EX,
                                                             F_SETLEASE, F_NOTIFY};
// Locks on a file, of a process or of an open file.
constexpr std::array<std::uint32_t, 4> lock_controls{F_SETLK, F_SETLKW, F_OFD_SETLK, F_OFD_SETLKW};
// The same for sockets; and characters typed into the terminal that the daemon was started from.
constexpr std::array<std::uint32_t, 4> refused_device_controls{FIOSETOWN, SIOCSPGRP, TIOCSTI,
                                                               TIOCLINUX};
// RLIMIT_DATA counts private writable memory only: not a mapping that is shared, which may have no
// file, nor one that grows like a stack. The solver and its libraries use neither.
constexpr std::uint32_t uncounted_mappings = MAP_SHARED | MAP_GROWSDOWN;

using Instruction = sock_filter;
using Filter = std::vector<Instruction>;

constexpr Instruction load(std::size_t offset) {
  return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
}
/// The first word of an argument, on a little-endian machine: all that these calls look at.
constexpr Instruction load_argument(std::size_t index) {
  return load(offsetof(seccomp_data, args) + index * sizeof(std::uint64_t));
}
/// @param steps  over the next instructions where the loaded word is not this
constexpr Instruction skip_unless(std::uint32_t word, std::uint8_t steps) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, word, 0, steps);
}
/// @param steps  over the next instructions where it is
constexpr Instruction skip_if(std::uint32_t word, std::uint8_t steps) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, word, steps, 0);
}
/// @param steps  over the next instructions where it has one of these bits
constexpr Instruction skip_if_any(std::uint32_t bits, std::uint8_t steps) {
  return BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, bits, steps, 0);
}
constexpr Instruction answer(std::uint32_t action) {
  return BPF_STMT(BPF_RET | BPF_K, action);
}

constexpr Instruction allow = answer(SECCOMP_RET_ALLOW);
constexpr Instruction refuse = answer(SECCOMP_RET_ERRNO | EPERM);
constexpr Instruction not_implemented = answer(SECCOMP_RET_ERRNO | ENOSYS);

/// Decides about one call. @param decision  ends with an answer on every way through it
void add_call(Filter& filter, long call, const Filter& decision) {
  filter.push_back(
      skip_unless(static_cast<std::uint32_t>(call), static_cast<std::uint8_t>(decision.size())));
  filter.insert(filter.end(), decision.begin(), decision.end());
}

/// Refuses these values of an argument.
Filter refuse_values(std::size_t argument, std::span<const std::uint32_t> values) {
  Filter decision{load_argument(argument)};
  std::size_t steps_to_refusal = values.size();
  for (const std::uint32_t value : values)
    decision.push_back(skip_if(value, static_cast<std::uint8_t>(steps_to_refusal--)));
  decision.insert(decision.end(), {allow, refuse});
  return decision;
}

/// Calls of another instruction set have other numbers: they are refused, all of them.
void require_machine(Filter& filter) {
  filter.insert(filter.end(), {load(offsetof(seccomp_data, arch)), skip_if(machine, 1),
                               machine == 0 ? allow : refuse, load(offsetof(seccomp_data, nr))});
#if defined(__x86_64__)
  constexpr std::uint32_t x32_calls = 0x40000000;
  filter.insert(filter.end(), {BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, x32_calls, 0, 1), refuse});
#endif
}

/// A worker makes threads, but no process: each would have the whole memory limit, and outlive job
/// and daemon. The flags of clone3() lie where no filter reads, and the C library does without it.
void permit_threads_alone(Filter& filter) {
  constexpr std::uint32_t namespaces = CLONE_NEWNS | CLONE_NEWCGROUP | CLONE_NEWUTS | CLONE_NEWIPC |
                                       CLONE_NEWUSER | CLONE_NEWPID | CLONE_NEWNET;
  // A sanitizer looks for leaks from a process that shares the memory of this one.
  constexpr std::uint32_t needed = sanitized ? CLONE_VM : CLONE_THREAD;

  add_call(filter, SYS_clone3, {not_implemented});
  add_call(filter, SYS_clone,
           {load_argument(0), skip_if_any(namespaces, 1), skip_if_any(needed, 1), refuse, allow});
#if defined(SYS_fork)  // not on every machine
  for (const long call : {SYS_fork, SYS_vfork}) add_call(filter, call, {refuse});
#endif
}

/// What names a process is permitted for this one.
void confine_to_own_process(Filter& filter) {
  const auto own = static_cast<std::uint32_t>(::getpid());
  for (const long call : signal_calls)
    add_call(filter, call, {load_argument(0), skip_unless(own, 1), allow, refuse});
  for (const long call : own_process_calls)
    add_call(filter, call, {load_argument(0), skip_if(0, 1), skip_unless(own, 1), allow, refuse});

  // Priorities of groups and users are those of other processes, too.
  add_call(filter, SYS_setpriority,
           {load_argument(0), skip_unless(PRIO_PROCESS, 4), load_argument(1), skip_if(0, 1),
            skip_unless(own, 1), allow, refuse});
}

Filter system_call_filter() {
  Filter filter;
  require_machine(filter);
  permit_threads_alone(filter);

  for (const long call : refused_calls) {
    const bool needed = std::ranges::find(sanitizer_calls, call) != sanitizer_calls.end();
    if (!sanitized || !needed) add_call(filter, call, {refuse});
  }
  confine_to_own_process(filter);
  add_call(filter, SYS_fcntl, refuse_values(1, refused_file_controls));
  add_call(filter, SYS_ioctl, refuse_values(1, refused_device_controls));
  if (!sanitized)
    add_call(filter, SYS_mmap,
             {load_argument(3), skip_if_any(uncounted_mappings, 1), allow, refuse});

  filter.push_back(allow);
  return filter;
}

/// A lock outlives no process, but holds up every other one that wants it: the daemon at its users,
/// its store and its folder, the worker of another job. The claim on the folder is taken before.
Filter lock_filter() {
  Filter filter;
  require_machine(filter);
  add_call(filter, SYS_flock, {refuse});
  add_call(filter, SYS_fcntl, refuse_values(1, lock_controls));
  filter.push_back(allow);
  return filter;
}

/// Adds a filter, for all threads. @return 0, or -1 and errno
long install(Filter filter) {
  const sock_fprog whole{static_cast<unsigned short>(filter.size()), filter.data()};
  return ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &whole);
}

/// Gives up all privileges of root: with them a worker of a daemon that runs as root could set the
/// clock or the name of the machine. @return whether that succeeded
bool drop_capabilities() {
  __user_cap_header_struct head{.version = _LINUX_CAPABILITY_VERSION_3, .pid = 0};
  const std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> none{};
  return ::syscall(SYS_capset, &head, none.data()) == 0;
}

/// Describes a missing restriction, with the error of the system. @param feature  of the kernel
std::string lacking(const char* consequence, const char* feature) {
  return fmt::format("{} ({}: {})", consequence, feature, ::strerror(errno));
}

// Debian 12's headers end at version 2 of Landlock; the numbers are the kernel's
// (include/uapi/linux/landlock.h of Linux 6.12).
struct Ruleset {
  std::uint64_t files = 0, network = 0, scope = 0;
};
constexpr std::uint64_t truncate = 1u << 14;             // version 3
constexpr std::uint64_t tcp = (1u << 0) | (1u << 1);     // version 4: bind, connect
constexpr std::uint64_t others = (1u << 0) | (1u << 1);  // version 6: abstract sockets, signals

// Of a file, and of the list of a folder.
constexpr std::uint64_t reading = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR;

/// What the program reads besides its work: libraries, time zones, the machine it runs on.
constexpr std::array program_files{"/usr",
                                   "/lib",
                                   "/lib64",
                                   "/etc/ld.so.cache",
                                   "/etc/localtime",
                                   "/etc/ssl/openssl.cnf",
                                   "/proc/self",
                                   "/proc/cpuinfo",
                                   "/sys/devices/system/cpu"};

/// All rights to change a file system that a version of Landlock knows.
constexpr std::uint64_t writing(long version) {
  std::uint64_t writes = 0;
  for (const std::uint64_t right :
       {LANDLOCK_ACCESS_FS_WRITE_FILE, LANDLOCK_ACCESS_FS_REMOVE_DIR,
        LANDLOCK_ACCESS_FS_REMOVE_FILE, LANDLOCK_ACCESS_FS_MAKE_CHAR, LANDLOCK_ACCESS_FS_MAKE_DIR,
        LANDLOCK_ACCESS_FS_MAKE_REG, LANDLOCK_ACCESS_FS_MAKE_SOCK, LANDLOCK_ACCESS_FS_MAKE_FIFO,
        LANDLOCK_ACCESS_FS_MAKE_BLOCK, LANDLOCK_ACCESS_FS_MAKE_SYM})
    writes |= right;
  if (version >= 2) writes |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= 3) writes |= truncate;
  return writes;
}

/// Permits access beneath a folder, or to a file. @return 0, or -1 and errno
long permit(const storage::FileDescriptor& ruleset, const std::filesystem::path& path,
            std::uint64_t rights) {
  const storage::FileDescriptor beneath(::open(path.c_str(), O_PATH | O_CLOEXEC));
  struct stat status {};
  if (!beneath || ::fstat(beneath.get(), &status) != 0) return -1;

  // A kernel refuses rights of folders for a file.
  if (!S_ISDIR(status.st_mode)) rights &= LANDLOCK_ACCESS_FS_READ_FILE;
  const landlock_path_beneath_attr rule{.allowed_access = rights, .parent_fd = beneath.get()};
  return ::syscall(SYS_landlock_add_rule, ruleset.get(), LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
}

/// @return 0, or -1 and errno
long restrict_files(long version, const Reach& reach) {
  const Ruleset rules{.files = reading | writing(version),
                      .network = version >= 4 ? tcp : 0,
                      .scope = version >= 6 ? others : 0};

  // A kernel refuses fields that it does not know.
  const std::size_t size = (version >= 6 ? 3 : version >= 4 ? 2 : 1) * sizeof(std::uint64_t);
  const storage::FileDescriptor ruleset(
      static_cast<int>(::syscall(SYS_landlock_create_ruleset, &rules, size, 0)));
  if (!ruleset) return -1;

  if (!reach.own.empty() && permit(ruleset, reach.own, rules.files) != 0) return -1;

  // The job that is read may be deleted meanwhile, and not every machine has each of the others.
  if (!reach.readable.empty()) permit(ruleset, reach.readable, reading);
  for (const char* path : program_files) permit(ruleset, path, reading);
  permit(ruleset, std::filesystem::path("/proc/self/exe"), reading);

  return ::syscall(SYS_landlock_restrict_self, ruleset.get(), 0);
}

std::int64_t default_memory_limit() {
  return static_cast<std::int64_t>(::sysconf(_SC_PHYS_PAGES)) * ::sysconf(_SC_PAGESIZE) / 10 * 9;
}

/// Lowers a limit; an existing lower one stays. @return the limit in force
rlim_t limit(__rlimit_resource resource, std::int64_t most) {
  rlimit now{};
  ::getrlimit(resource, &now);
  const rlim_t least = std::min<rlim_t>(static_cast<rlim_t>(most), now.rlim_max);
  const rlimit lower{least, least};
  return ::setrlimit(resource, &lower) == 0 ? least : now.rlim_cur;
}

std::string describe_limit(const char* resource, rlim_t bytes) {
  if (bytes == RLIM_INFINITY) return fmt::format("{} of any size", resource);
  return fmt::format("{} up to {}", resource, storage::megabytes(static_cast<std::int64_t>(bytes)));
}

std::atomic<bool> file_bound_met = false;
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void note_file_bound(int) {
  file_bound_met = true;
}

/// A process that cannot map this much more has no memory left for a step.
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
  jobs::forbid_inspection();

  if (!drop_capabilities()) return lacking("keeps the privileges of its user", "capset");

  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return lacking("may gain privileges", "prctl");
  if (install(system_call_filter()) != 0) return lacking("may use the network", "seccomp");
  return "no network, no other processes (seccomp)";
}

std::string confine_to(const Reach& reach) {
  const std::string locks = install(lock_filter()) == 0
                                ? "no locks on files (seccomp)"
                                : lacking("may lock what its user may", "seccomp");

  const long version =
      ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 0 || restrict_files(version, reach) != 0)
    return fmt::format("{}, {}", locks, lacking("reads and writes where its user may", "Landlock"));

  std::string writes = "writes no file";
  if (!reach.own.empty()) writes = fmt::format("writes only beneath {}", reach.own.string());
  std::string reads = "reads only there and its program";
  if (!reach.readable.empty()) reads += fmt::format(" and {}", reach.readable.string());
  return fmt::format("{}, {}, {} (Landlock {})", locks, writes, reads, version);
}

std::string bound(const Bounds& bounds) {
  const std::int64_t memory =
      bounds.memory_bytes > 0 ? bounds.memory_bytes : default_memory_limit();
  std::string text = sanitized ? "memory without a bound (sanitizer)"
                               : describe_limit("memory", limit(RLIMIT_DATA, memory));
  if (bounds.file_bytes <= 0) return text;

  ::signal(SIGXFSZ, note_file_bound);  // the write fails, too
  return text + describe_limit(", files", limit(RLIMIT_FSIZE, bounds.file_bytes));
}

bool met_file_bound() {
  return file_bound_met;
}

void name_memory_exhaustion() {
  // The handler has a stack of its own, because the crash may be an overflow of the stack.
  static std::array<std::byte, 65536> stack;
  const stack_t alternative{.ss_sp = stack.data(), .ss_flags = 0, .ss_size = stack.size()};
  ::sigaltstack(&alternative, nullptr);

  struct sigaction action {};
  action.sa_handler = on_crash;
  action.sa_flags = SA_ONSTACK | SA_NODEFER;
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT}) ::sigaction(signal, &action, nullptr);

  std::set_new_handler(note_failed_allocation);
}

}  // namespace dccast::worker
