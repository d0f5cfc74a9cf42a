// Linked into every program that DCCAST_SANITIZE builds: what the sanitizers are asked for, which
// faults of libraries they leave out, and where reports go.
#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

extern "C" {

void __sanitizer_set_report_fd(void* descriptor);

// Tests preload libraries in front of the sanitizer's own.
const char* __asan_default_options() {
  return "verify_asan_link_order=0:strict_string_checks=1";
}

const char* __ubsan_default_options() {
  return "print_stacktrace=1";
}

// HDF5 1.10 does not free what it has made of a file that turns out to be damaged: a worker that
// answers ends after 200 answers.
const char* __lsan_default_suppressions() {
  return "leak:libhdf5_serial\n";
}

// gRPC, Protobuf and OpenSSL of Debian are not instrumented. A client that is interrupted ends
// after a second, whatever its threads are at.
const char* __tsan_default_options() {
  return "ignore_noninstrumented_modules=1:second_deadlock_stack=1:report_thread_leaks=0";
}

// A call's operations go from the thread that starts them to the one that completes them through
// gRPC's queues, which have no locks, and so do the messages of a call that are written and read.
// Only what gRPC itself reads or writes is left out.
const char* __tsan_default_suppressions() {
  return "race_top:grpc::\n"
         "race_top:std::function<void (bool)>\n"
         "race_top:std::function<void ()>::operator\n"
         "race_top:std::_Function_base::_M_empty\n"
         "race:grpc::internal::CallOpSendMessage::SendMessage\n"
         "race:grpc::internal::CallOpSet<grpc::internal::CallOpRecvMessage*FinalizeResult\n"
         "race:grpc::internal::InterceptorBatchMethodsImpl::~InterceptorBatchMethodsImpl\n";
}

}  // extern "C"

namespace {

void* as_report_output(int descriptor) {
  return reinterpret_cast<void*>(std::intptr_t{descriptor});
}

int reports = -1;

// A report of a service's process must not be lost in a log that its test removes. The file is
// opened before main: a worker may write only beneath its job's folder later.
[[gnu::constructor]] void open_reports() {
  const char* folder = std::getenv("DCCAST_SANITIZER_REPORTS");
  if (folder == nullptr || *folder == '\0') return;
  char path[4096];
  std::snprintf(path, sizeof path, "%s/%s.%d", folder, program_invocation_short_name, ::getpid());
  const int file = ::open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file < 0) return;
  reports = ::fcntl(file, F_DUPFD_CLOEXEC, 0);
  __sanitizer_set_report_fd(as_report_output(file));
}

}  // namespace

// GCC's library of undefined behaviour has an output of its own. With its first report it begins,
// and closes what the other library was given.
extern "C" void __ubsan_on_report() {
  void* const library = ::dlopen("libubsan.so.1", RTLD_NOW | RTLD_NOLOAD);
  if (library == nullptr || reports < 0) return;
  using SetReport = void (*)(void*);
  reinterpret_cast<SetReport>(::dlsym(library, "__sanitizer_set_report_fd"))(
      as_report_output(reports));
}

#if defined(__SANITIZE_THREAD__)

// Abseil's locks, which gRPC hands its calls over by, are atomics of a library that is not
// instrumented. Their functions are replaced by these, which report them to the sanitizer.
extern "C" {

void __tsan_acquire(void* address);
void __tsan_release(void* address);

struct AbseilTime {  // of absl::Duration and absl::Time
  std::int64_t high;
  std::uint32_t low;
};

void abseil_lock(void* mutex) asm("_ZN4absl7debian35Mutex4LockEv");
void abseil_unlock(void* mutex) asm("_ZN4absl7debian35Mutex6UnlockEv");
bool abseil_try_lock(void* mutex) asm("_ZN4absl7debian35Mutex7TryLockEv");
void abseil_wait(void* condition, void* mutex) asm("_ZN4absl7debian37CondVar4WaitEPNS0_5MutexE");
bool abseil_wait_for(void* condition, void* mutex, AbseilTime time) asm(
    "_ZN4absl7debian37CondVar15WaitWithTimeoutEPNS0_5MutexENS0_8DurationE");
bool abseil_wait_until(void* condition, void* mutex, AbseilTime time) asm(
    "_ZN4absl7debian37CondVar16WaitWithDeadlineEPNS0_5MutexENS0_4TimeE");

void abseil_lock(void* mutex) {
  static const auto next =
      reinterpret_cast<decltype(&abseil_lock)>(::dlsym(RTLD_NEXT, "_ZN4absl7debian35Mutex4LockEv"));
  next(mutex);
  __tsan_acquire(mutex);
}

void abseil_unlock(void* mutex) {
  static const auto next = reinterpret_cast<decltype(&abseil_unlock)>(
      ::dlsym(RTLD_NEXT, "_ZN4absl7debian35Mutex6UnlockEv"));
  __tsan_release(mutex);
  next(mutex);
}

bool abseil_try_lock(void* mutex) {
  static const auto next = reinterpret_cast<decltype(&abseil_try_lock)>(
      ::dlsym(RTLD_NEXT, "_ZN4absl7debian35Mutex7TryLockEv"));
  const bool locked = next(mutex);
  if (locked) __tsan_acquire(mutex);
  return locked;
}

void abseil_wait(void* condition, void* mutex) {
  static const auto next = reinterpret_cast<decltype(&abseil_wait)>(
      ::dlsym(RTLD_NEXT, "_ZN4absl7debian37CondVar4WaitEPNS0_5MutexE"));
  __tsan_release(mutex);
  next(condition, mutex);
  __tsan_acquire(mutex);
}

bool abseil_wait_for(void* condition, void* mutex, AbseilTime time) {
  static const auto next = reinterpret_cast<decltype(&abseil_wait_for)>(
      ::dlsym(RTLD_NEXT, "_ZN4absl7debian37CondVar15WaitWithTimeoutEPNS0_5MutexENS0_8DurationE"));
  __tsan_release(mutex);
  const bool timed_out = next(condition, mutex, time);
  __tsan_acquire(mutex);
  return timed_out;
}

bool abseil_wait_until(void* condition, void* mutex, AbseilTime time) {
  static const auto next = reinterpret_cast<decltype(&abseil_wait_until)>(
      ::dlsym(RTLD_NEXT, "_ZN4absl7debian37CondVar16WaitWithDeadlineEPNS0_5MutexENS0_4TimeE"));
  __tsan_release(mutex);
  const bool timed_out = next(condition, mutex, time);
  __tsan_acquire(mutex);
  return timed_out;
}

}  // extern "C"
#endif
