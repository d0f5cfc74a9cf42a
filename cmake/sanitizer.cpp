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

// gRPC, Abseil, Protobuf and OpenSSL of Debian are not instrumented: their locks are not seen.
const char* __tsan_default_options() {
  return "ignore_noninstrumented_modules=1:second_deadlock_stack=1";
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
  if (folder == nullptr) return;
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
