// Preloaded into the daemon and its workers: a disk that fails while a file says so. For users who
// cannot mount a small one, and for errors that no small one gives. README.md has the format.
#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

struct Order {
  int error = 0;             // what the calls give; 0: they take 2 s and succeed
  char calls[16] = "";       // which ones, see README.md
  long times = -1;           // how often in each process; -1: always
  char part[PATH_MAX] = "";  // of the path; "-": any below the folder
};

/// Reads a small file without any call that is replaced below. @return bytes, 0 when it is not
/// there
std::size_t read_raw(const char* path, char* text, std::size_t size, ino_t& inode) {
  const long file = ::syscall(SYS_openat, AT_FDCWD, path, O_RDONLY | O_CLOEXEC, 0);
  if (file < 0) return 0;
  const long got = ::syscall(SYS_read, file, text, size - 1);
  struct stat status;
  inode = ::fstat(static_cast<int>(file), &status) == 0 ? status.st_ino : 0;
  ::syscall(SYS_close, file);
  text[got > 0 ? got : 0] = '\0';
  return got > 0 ? static_cast<std::size_t>(got) : 0;
}

/// Counts down what is left of an order; a new file is a new order.
bool some_left(long times, ino_t inode) {
  static std::atomic<ino_t> known{0};
  static std::atomic<long> left{0};
  if (times < 0) return true;
  if (known.exchange(inode) != inode) left = times;
  return left.fetch_sub(1) > 0;
}

bool below_the_folder(const char* path, const Order& order) {
  const char* folder = ::getenv("DCCAST_FAULT_FOLDER");
  if (folder == nullptr || ::strncmp(path, folder, ::strlen(folder)) != 0) return false;
  return ::strcmp(order.part, "-") == 0 || ::strstr(path, order.part) != nullptr;
}

/// Whether this call fails now; sets errno then. @param call  a letter of README.md
bool fails(char call, const char* path) {
  const char* file = ::getenv("DCCAST_FAULT_FILE");
  if (file == nullptr || path == nullptr) return false;
  const int before = errno;
  char text[PATH_MAX + 64];
  ino_t inode = 0;
  Order order;
  const bool ordered = read_raw(file, text, sizeof text, inode) > 0 &&
                       ::sscanf(text, "%d %15s %ld %4095s", &order.error, order.calls, &order.times,
                                order.part) == 4;
  errno = before;
  if (!ordered || ::strchr(order.calls, call) == nullptr) return false;
  if (!below_the_folder(path, order) || !some_left(order.times, inode)) return false;
  if (order.error == 0) {  // a slow disk: the call takes its time and succeeds
    constexpr timespec delay{.tv_sec = 2, .tv_nsec = 0};
    ::nanosleep(&delay, nullptr);  // see above
    errno = before;
    return false;
  }
  errno = order.error;
  return true;
}

bool fails(char call, int descriptor) {
  if (::getenv("DCCAST_FAULT_FILE") == nullptr) return false;
  const int before = errno;
  char link[64];
  char path[PATH_MAX];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const long length = ::syscall(SYS_readlinkat, AT_FDCWD, link, path, sizeof path - 1);
  errno = before;
  if (length <= 0) return false;
  path[length] = '\0';
  return fails(call, path);
}

bool open_fails(const char* path, int flags) {
  const bool writes = (flags & O_ACCMODE) != O_RDONLY || (flags & O_CREAT) != 0;
  return fails(writes ? 'o' : 'r', path);
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

// NOLINTBEGIN: the names and shapes are those of the C library.
#define DCCAST_REPLACED extern "C" __attribute__((visibility("default")))

#define DCCAST_OPEN(name)                                                 \
  DCCAST_REPLACED int name(const char* path, int flags, ...) {            \
    va_list rest;                                                         \
    va_start(rest, flags);                                                \
    const mode_t mode = (flags & O_CREAT) ? va_arg(rest, mode_t) : 0;     \
    va_end(rest);                                                         \
    if (open_fails(path, flags)) return -1;                               \
    static const auto real = next<int (*)(const char*, int, ...)>(#name); \
    return real(path, flags, mode);                                       \
  }
DCCAST_OPEN(open)
DCCAST_OPEN(open64)

#define DCCAST_WRITE(name, Offset)                                                       \
  DCCAST_REPLACED ssize_t name(int file, const void* bytes, size_t size, Offset at) {    \
    if (fails('w', file)) return -1;                                                     \
    static const auto real = next<ssize_t (*)(int, const void*, size_t, Offset)>(#name); \
    return real(file, bytes, size, at);                                                  \
  }
DCCAST_WRITE(pwrite, off_t)
DCCAST_WRITE(pwrite64, off64_t)

DCCAST_REPLACED ssize_t write(int file, const void* bytes, size_t size) {
  if (fails('w', file)) return -1;
  static const auto real = next<ssize_t (*)(int, const void*, size_t)>("write");
  return real(file, bytes, size);
}

DCCAST_REPLACED ssize_t writev(int file, const struct iovec* parts, int count) {
  if (fails('w', file)) return -1;
  static const auto real = next<ssize_t (*)(int, const struct iovec*, int)>("writev");
  return real(file, parts, count);
}

#define DCCAST_SYNC(name)                               \
  DCCAST_REPLACED int name(int file) {                  \
    if (fails('s', file)) return -1;                    \
    static const auto real = next<int (*)(int)>(#name); \
    return real(file);                                  \
  }
DCCAST_SYNC(fsync)
DCCAST_SYNC(fdatasync)

DCCAST_REPLACED int mkdir(const char* path, mode_t mode) noexcept {
  if (fails('o', path)) return -1;
  static const auto real = next<int (*)(const char*, mode_t)>("mkdir");
  return real(path, mode);
}

DCCAST_REPLACED int rename(const char* from, const char* to) noexcept {
  if (fails('n', from)) return -1;
  static const auto real = next<int (*)(const char*, const char*)>("rename");
  return real(from, to);
}
// NOLINTEND
