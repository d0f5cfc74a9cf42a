#include "server/jobs/durable_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace dccast::jobs {

namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

}  // namespace

FileDescriptor::~FileDescriptor() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

FileDescriptor open_file(const std::filesystem::path& path, int flags) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC, 0600);
  if (descriptor < 0) fail("cannot open " + path.string());
  return FileDescriptor(descriptor);
}

std::size_t read_at(int descriptor, std::int64_t offset, std::span<char> bytes) {
  for (;;) {
    const ssize_t got = ::pread(descriptor, bytes.data(), bytes.size(), offset);
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR) fail("cannot read");
  }
}

std::int64_t size_of_file(int descriptor) {
  struct stat status;
  if (::fstat(descriptor, &status) != 0) fail("cannot look at a file");
  return status.st_size;
}

std::string read_file(const std::filesystem::path& path) {
  const FileDescriptor file = open_file(path, O_RDONLY);
  std::string content(static_cast<std::size_t>(size_of_file(file.get())), '\0');
  content.resize(read_at(file.get(), 0, content));
  return content;
}

void write_at(int descriptor, std::int64_t offset, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::pwrite(descriptor, bytes.data(), bytes.size(), offset);
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) fail("cannot write");
    bytes.remove_prefix(static_cast<std::size_t>(put));
    offset += put;
  }
}

void sync_file(int descriptor) {
  if (::fdatasync(descriptor) != 0) fail("cannot sync a file to disk");
}

void sync_directory(const std::filesystem::path& directory) {
  const FileDescriptor opened = open_file(directory, O_RDONLY | O_DIRECTORY);
  if (::fsync(opened.get()) != 0) fail("cannot sync " + directory.string() + " to disk");
}

void write_durably(const std::filesystem::path& path, std::string_view content) {
  const FileDescriptor file = open_file(path, O_WRONLY | O_CREAT | O_EXCL);
  write_at(file.get(), 0, content);
  if (::fsync(file.get()) != 0) fail("cannot sync " + path.string() + " to disk");
}

void replace_file(const std::filesystem::path& path, std::string_view content) {
  const std::filesystem::path next = path.string() + ".next";
  {
    const FileDescriptor file = open_file(next, O_WRONLY | O_CREAT | O_TRUNC);
    write_at(file.get(), 0, content);
    sync_file(file.get());
  }
  std::filesystem::rename(next, path);
}

}  // namespace dccast::jobs
