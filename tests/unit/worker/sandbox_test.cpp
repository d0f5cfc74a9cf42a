#include "server/worker/sandbox.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/sockios.h>
#include <sched.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <functional>
#include <new>
#include <thread>
#include <vector>

#include "core/casting/simulation.hpp"
#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::worker {
namespace {

namespace fs = std::filesystem;

/// The status of a child that does this; its own end is exit code 0.
int status_of_child(const std::function<void()>& act) {
  const pid_t child = ::fork();
  if (child == 0) {
    act();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return status;
}

/// Ends the child where something is not so.
#define MUST(what)                                               \
  if (!(what)) {                                                 \
    std::cerr << "not so: " #what << ": " << errno << std::endl; \
    ::_exit(1);                                                  \
  }

bool refused(long result) {
  return result < 0 && (errno == EPERM || errno == EACCES);
}

bool has_landlock() {
  return ::syscall(SYS_landlock_create_ruleset, nullptr, 0, 1) > 0;
}

class SandboxTest : public ::testing::Test {
protected:
  SandboxTest() {
    fs::create_directories(own_);
    fs::create_directories(other_);
    storage::write_file(other_ / "file", "of another job");
    storage::write_file(own_ / "old", "of an earlier attempt");
  }
  TemporaryFolder folder_;
  const fs::path own_ = folder_ / "own", other_ = folder_ / "other";
};

TEST_F(SandboxTest, WritesWhatItLikesBeneathItsFolder) {
  EXPECT_EQ(
      status_of_child([&] {
        confine_to({.own = own_, .readable = other_});
        storage::write_file(own_ / "results.h5.part", "frames");
        MUST(::rename((own_ / "results.h5.part").c_str(), (own_ / "results.h5").c_str()) == 0);
        MUST(::truncate((own_ / "old").c_str(), 3) == 0);
        MUST(::unlink((own_ / "old").c_str()) == 0);
        MUST(::mkdir((own_ / "more").c_str(), 0700) == 0);
        MUST(::rename((own_ / "results.h5").c_str(), (own_ / "more/results.h5").c_str()) == 0);
        MUST(storage::read_file(other_ / "file") == "of another job");
      }),
      0);
}

TEST_F(SandboxTest, WritesNothingElsewhere) {
  if (!has_landlock()) GTEST_SKIP() << "the kernel has no Landlock";
  const fs::path file = other_ / "file", made = other_ / "new";
  EXPECT_EQ(status_of_child([&] {
              confine_to({.own = own_});
              MUST(refused(::open(file.c_str(), O_WRONLY)));
              MUST(refused(::open(file.c_str(), O_RDWR | O_APPEND)));
              MUST(refused(::open(made.c_str(), O_WRONLY | O_CREAT, 0600)));
              MUST(refused(::open("/tmp", O_WRONLY | O_TMPFILE, 0600)));
              MUST(refused(::unlink(file.c_str())));
              MUST(refused(::mkdir(made.c_str(), 0700)));
              MUST(refused(::symlink("file", made.c_str())));
              MUST(refused(::mkfifo(made.c_str(), 0600)));
              MUST(refused(::rename(file.c_str(), made.c_str())));
              MUST(::rename((own_ / "old").c_str(), made.c_str()) < 0);
              MUST(::link(file.c_str(), (own_ / "link").c_str()) < 0);
              // A link out of the folder is no way out of it.
              MUST(::symlink(file.c_str(), (own_ / "way").c_str()) == 0);
              MUST(refused(::open((own_ / "way").c_str(), O_WRONLY)));
              // Nor is a second confinement.
              confine_to({.own = other_});
              MUST(refused(::open(file.c_str(), O_WRONLY)));
            }),
            0);
  EXPECT_EQ(storage::read_file(file), "of another job");
}

TEST_F(SandboxTest, WithoutAFolderWritesNowhere) {
  if (!has_landlock()) GTEST_SKIP() << "the kernel has no Landlock";
  EXPECT_EQ(status_of_child([&] {
              confine_to({});
              MUST(refused(::open((own_ / "old").c_str(), O_WRONLY)));
            }),
            0);
}

/// The job whose frames it reads may be deleted before.
TEST_F(SandboxTest, AFolderThatIsGoneOpensNoOther) {
  if (!has_landlock()) GTEST_SKIP() << "the kernel has no Landlock";
  EXPECT_EQ(status_of_child([&] {
              confine_to({.own = own_, .readable = folder_ / "gone"});
              MUST(refused(::open((other_ / "file").c_str(), O_RDONLY)));
              MUST(refused(::open((other_ / "new").c_str(), O_WRONLY | O_CREAT, 0600)));
              MUST(storage::read_file(own_ / "old") == "of an earlier attempt");
            }),
            0);
}

TEST_F(SandboxTest, ReadsItsFolderItsProgramAndNothingElse) {
  if (!has_landlock()) GTEST_SKIP() << "the kernel has no Landlock";
  EXPECT_EQ(status_of_child([&] {
              confine_to({.own = own_});
              MUST(storage::read_file(own_ / "old") == "of an earlier attempt");
              MUST(!fs::directory_iterator(own_)->path().empty());
              MUST(::open("/proc/self/exe", O_RDONLY) >= 0);
              MUST(::open("/proc/self/status", O_RDONLY) >= 0);
              MUST(refused(::open((other_ / "file").c_str(), O_RDONLY)));
              MUST(refused(::open(other_.c_str(), O_RDONLY | O_DIRECTORY)));
              MUST(refused(::open("/etc/passwd", O_RDONLY)));
              MUST(refused(
                  ::open(("/proc/" + std::to_string(::getppid()) + "/status").c_str(), O_RDONLY)));
              // The file is there all the same: a job without a daemon looks for its time.
              MUST(fs::exists(other_ / "file"));
            }),
            0);
}

/// A lock on the daemon's files, or on those of another job, would hold up those that wait for it.
TEST_F(SandboxTest, LocksNoFile) {
  EXPECT_EQ(status_of_child([&] {
              const int own = ::open((own_ / "old").c_str(), O_RDWR);
              const int open_before = ::open((other_ / "file").c_str(), O_RDWR);
              struct flock whole {};
              whole.l_type = F_WRLCK;
              whole.l_whence = SEEK_SET;
              isolate();
              MUST(::fcntl(own, F_SETLK, &whole) == 0);  // the claim on the folder

              confine_to({.own = own_});
              for (const int file : {own, open_before}) {
                for (const int kind : {F_SETLK, F_SETLKW, F_OFD_SETLK, F_OFD_SETLKW})
                  MUST(refused(::fcntl(file, kind, &whole)));
                MUST(refused(::flock(file, LOCK_SH | LOCK_NB)));
              }
              MUST(::fcntl(own, F_GETLK, &whole) == 0);
              std::thread([&] { MUST(refused(::flock(own, LOCK_EX | LOCK_NB))); }).join();
            }),
            0);
}

TEST_F(SandboxTest, HasNoNetwork) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0);

  const int made_before = ::socket(AF_INET, SOCK_STREAM, 0);
  EXPECT_EQ(status_of_child([&] {
              isolate();
              for (const int family : {AF_INET, AF_INET6, AF_UNIX, AF_NETLINK})
                MUST(refused(::socket(family, SOCK_STREAM, 0)));
              const sockaddr nowhere{};
              MUST(refused(::connect(made_before, &nowhere, sizeof nowhere)));
              MUST(refused(::bind(made_before, &nowhere, sizeof nowhere)));
              MUST(refused(::listen(made_before, 1)));
              MUST(refused(::syscall(SYS_io_uring_setup, 1, nullptr)));
              MUST(::write(ends[0], "answer", 6) == 6);  // the link to the daemon
            }),
            0);

  for (const int each : {ends[0], ends[1], made_before}) ::close(each);
}

TEST_F(SandboxTest, ReachesNoOtherProcess) {
  const pid_t parent = ::getpid();
  EXPECT_EQ(status_of_child([&] {
              isolate();
              MUST(refused(::kill(parent, 0)));
              MUST(refused(::kill(-1, 0)));
              MUST(refused(::syscall(SYS_tgkill, parent, parent, 0)));
              MUST(refused(::syscall(SYS_tkill, parent, 0)));
              MUST(sanitized || refused(::ptrace(PTRACE_ATTACH, parent, nullptr, nullptr)));
              int word = 0;
              iovec to{&word, sizeof word}, from{&word, sizeof word};
              MUST(refused(::process_vm_readv(parent, &to, 1, &from, 1, 0)));
              MUST(::prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0) == 1);
            }),
            0);
}

/// Each of these stops or ends a daemon of the same user: without processor time, without files,
/// or by a signal that the kernel sends for us.
TEST_F(SandboxTest, ChangesNoOtherProcess) {
  const pid_t parent = ::getpid();
  EXPECT_EQ(status_of_child([&] {
              const int pipe = ::open("/dev/null", O_RDONLY);
              isolate();
              rlimit limit{};
              MUST(::prlimit(0, RLIMIT_NOFILE, nullptr, &limit) == 0);
              MUST(::prlimit(::getpid(), RLIMIT_NOFILE, &limit, nullptr) == 0);
              MUST(refused(::prlimit(parent, RLIMIT_NOFILE, nullptr, &limit)));
              MUST(refused(::prlimit(parent, RLIMIT_CPU, &limit, nullptr)));

              MUST(::setpriority(PRIO_PROCESS, 0, 10) == 0);
              MUST(::setpriority(PRIO_PROCESS, static_cast<id_t>(::getpid()), 11) == 0);
              MUST(refused(::setpriority(PRIO_PROCESS, static_cast<id_t>(parent), 19)));
              MUST(refused(::setpriority(PRIO_PGRP, 0, 19)));
              MUST(refused(::setpriority(PRIO_USER, 0, 19)));
              cpu_set_t processors;
              MUST(::sched_getaffinity(0, sizeof processors, &processors) == 0);
              MUST(refused(::sched_setaffinity(parent, sizeof processors, &processors)));
              const sched_param plain{};
              MUST(refused(::sched_setscheduler(parent, SCHED_IDLE, &plain)));
              MUST(refused(::syscall(SYS_ioprio_set, 1, parent, 3 << 13)));

              MUST(refused(::fcntl(pipe, F_SETOWN, parent)));
              MUST(refused(::fcntl(pipe, F_SETSIG, SIGKILL)));
              f_owner_ex owner{F_OWNER_PID, parent};
              MUST(refused(::fcntl(pipe, F_SETOWN_EX, &owner)));
              MUST(refused(::fcntl(pipe, F_SETLEASE, F_RDLCK)));
              pid_t other = parent;
              MUST(refused(::ioctl(pipe, FIOSETOWN, &other)));
              MUST(refused(::ioctl(pipe, TIOCSTI, "x")));
              MUST(::fcntl(pipe, F_GETFL) >= 0);
            }),
            0);
}

/// A user namespace has every privilege inside; clone() makes one as unshare() does.
TEST_F(SandboxTest, MakesNoNamespaceAndStartsNoOtherProgram) {
  EXPECT_EQ(status_of_child([] {
              isolate();
              MUST(refused(::unshare(CLONE_NEWUSER)));
              MUST(refused(::syscall(SYS_clone, CLONE_NEWUSER | SIGCHLD, 0, 0, 0, 0)));
              MUST(::syscall(SYS_clone3, nullptr, 0) < 0 && errno == ENOSYS);
              MUST(refused(::syscall(SYS_execveat, AT_FDCWD, "/bin/true", nullptr, nullptr, 0)));
              int made = 0;
              std::thread([&] { made = 1; }).join();
              MUST(made == 1);
            }),
            0);
}

#if defined(SYS_fork)
constexpr std::array<long, 2> calls_that_fork{SYS_fork, SYS_vfork};
#else
constexpr std::array<long, 0> calls_that_fork{};
#endif

/// A process of its own would have the whole memory limit once more, and outlive job and daemon.
TEST_F(SandboxTest, MakesThreadsButNoProcess) {
  EXPECT_EQ(status_of_child([] {
              isolate();
              MUST(::fork() < 0 && errno == EPERM);
              for (const long call : calls_that_fork) MUST(refused(::syscall(call)));
              MUST(refused(::syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0)));
              MUST(sanitized ||
                   refused(::syscall(SYS_clone, CLONE_VM | CLONE_VFORK | SIGCHLD, 0, 0, 0, 0)));
              std::vector<std::thread> threads;
              std::atomic<int> made = 0;
              for (int i = 0; i < 8; ++i) threads.emplace_back([&] { ++made; });
              for (std::thread& thread : threads) thread.join();
              MUST(made == 8);
            }),
            0);
}

TEST_F(SandboxTest, HasNoPrivilegeAlsoAsRoot) {
  EXPECT_EQ(status_of_child([] {
              std::array<char, 64> name{};
              MUST(::gethostname(name.data(), name.size()) == 0);
              isolate();
              MUST(refused(::sethostname(name.data(), 1)));
              MUST(refused(::chroot("/")));
              timeval now{};
              ::gettimeofday(&now, nullptr);
              MUST(refused(::settimeofday(&now, nullptr)));
            }),
            0);
}

TEST_F(SandboxTest, EndsItselfAsBefore) {
  const int status = status_of_child([] {
    isolate();
    ::abort();
  });
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGABRT);
  EXPECT_FALSE(WCOREDUMP(status));
}

TEST_F(SandboxTest, StatesWhatIsInForce) {
  const fs::path log = folder_ / "log";
  EXPECT_EQ(status_of_child([&] {
              const std::string text =
                  isolate() + "\n" + confine_to({.own = own_}) + "\n" +
                  bound({.memory_bytes = 900'000'000, .file_bytes = 7'000'000});
              MUST(text.starts_with("no network, no other processes (seccomp)\n"));
              MUST(text.find(has_landlock()
                                 ? "writes only beneath " + own_.string() + ", reads only there"
                                 : "reads and writes where its user may (Landlock: ") !=
                   std::string::npos);
              MUST(text.find("\nno locks on files (seccomp), ") != std::string::npos);
              MUST(text.ends_with(", files up to 7 MB"));
            }),
            0);
}

TEST_F(SandboxTest, MemoryAndFilesHaveBounds) {
  EXPECT_EQ(status_of_child([&] {
              bound({.memory_bytes = 300'000'000, .file_bytes = 1'000'000});
              const storage::File file(own_ / "large", O_RDWR | O_CREAT);
              file.write_at(0, std::string(900'000, 'x'));
              MUST(!met_file_bound());
              MUST(::pwrite(file.descriptor(), "x", 1, 1'000'000) < 0 && errno == EFBIG);
              MUST(met_file_bound());
              if (sanitized) ::_exit(0);
              bool refused_memory = false;
              try {
                const std::vector<char> too_much(400'000'000, 'x');
              } catch (const std::bad_alloc&) {
                refused_memory = true;
              }
              MUST(refused_memory);
            }),
            0);
}

/// RLIMIT_DATA counts private memory that can be written: not what is shared, nor a stack.
TEST_F(SandboxTest, NoMemoryEvadesItsBound) {
  if (sanitized) GTEST_SKIP() << "a sanitizer has no bound of memory";
  EXPECT_EQ(status_of_child([] {
              isolate();
              bound({.memory_bytes = 300'000'000});
              constexpr std::size_t too_much = 400'000'000;
              constexpr int all = PROT_READ | PROT_WRITE;
              const auto maps = [&](std::size_t size, int flags) {
                return ::mmap(nullptr, size, all, flags | MAP_ANONYMOUS, -1, 0) != MAP_FAILED;
              };
              MUST(maps(1'000'000, MAP_PRIVATE));
              MUST(!maps(too_much, MAP_PRIVATE));
              MUST(!maps(too_much, MAP_SHARED) && errno == EPERM);
              MUST(!maps(too_much, MAP_PRIVATE | MAP_GROWSDOWN) && errno == EPERM);
              MUST(refused(::syscall(SYS_memfd_create, "memory", 0)));
              MUST(refused(::shmget(IPC_PRIVATE, too_much, 0600)));
              std::array<int, 2> ends{};
              MUST(refused(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data())));
            }),
            0);
}

TEST_F(SandboxTest, ACastingHasTheSameResultsBitByBit) {
  const auto cast_into = [](const fs::path& folder) {
    casting::testing::Recorder recorder;
    const auto outcome =
        casting::run(casting::testing::small_casting(), {.path = folder}, recorder);
    MUST(outcome.end == casting::RunEnd::succeeded);
  };
  EXPECT_EQ(status_of_child([&] { cast_into(other_); }), 0);
  EXPECT_EQ(status_of_child([&] {
              isolate();
              confine_to({.own = own_});
              bound({.memory_bytes = 2'000'000'000, .file_bytes = 1'000'000'000});
              cast_into(own_);
            }),
            0);
  EXPECT_EQ(values::sha256_of_file(own_ / "results.h5"),
            values::sha256_of_file(other_ / "results.h5"));
}

}  // namespace
}  // namespace dccast::worker
