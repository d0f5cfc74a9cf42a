#include "core/results/durable_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <utility>

#include "core/results/storage_error.hpp"

namespace dccast::results {

namespace fs = std::filesystem;

FileDescriptor::FileDescriptor(const fs::path& path, int flags)
    : descriptor_(::open(path.c_str(), flags | O_CLOEXEC, 0644)), path_(path) {
  if (descriptor_ < 0) throw StorageError(errno, path.string(), "cannot be opened");
}

FileDescriptor::FileDescriptor(FileDescriptor&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), path_(std::move(other.path_)) {}

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  if (this != &other) {
    close();
    descriptor_ = std::exchange(other.descriptor_, -1);
    path_ = std::move(other.path_);
  }
  return *this;
}

FileDescriptor::~FileDescriptor() {
  close();
}

void FileDescriptor::close() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

void FileDescriptor::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw StorageError(errno, path_.string(), "cannot be written");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void FileDescriptor::sync() {
  if (::fsync(descriptor_) != 0)
    throw StorageError(errno, path_.string(), "cannot be synchronised");
}

std::string read_file(const fs::path& path) {
  const FileDescriptor file(path, O_RDONLY);
  std::string content;
  char piece[1 << 16];
  for (;;) {
    const ssize_t got = ::read(file.get(), piece, sizeof piece);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw StorageError(errno, path.string(), "cannot be read");
    if (got == 0) return content;
    content.append(piece, static_cast<std::size_t>(got));
  }
}

void write_file(const fs::path& path, std::string_view bytes) {
  FileDescriptor(path, O_WRONLY | O_CREAT | O_TRUNC).write(bytes);
}

void publish(std::initializer_list<Publication> files) {
  for (const Publication& file : files) FileDescriptor(file.finished, O_RDONLY).sync();
  for (const auto& [finished, final_path] : files)
    if (std::rename(finished.c_str(), final_path.c_str()) != 0)
      throw StorageError(errno, final_path.string(), "cannot be given its final name");
  const fs::path final_path = files.begin()->final_path;
  const fs::path folder = final_path.has_parent_path() ? final_path.parent_path() : fs::path(".");
  FileDescriptor(folder, O_RDONLY | O_DIRECTORY).sync();
}

void write_file_atomically(const fs::path& path, std::string_view bytes) {
  fs::path temporary = path;
  temporary += ".tmp";
  write_file(temporary, bytes);
  publish({{temporary, path}});
}

}  // namespace dccast::results
