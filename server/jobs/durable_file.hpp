#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace dccast::jobs {

/// Owns a file descriptor.
class FileDescriptor {
public:
  FileDescriptor() = default;
  explicit FileDescriptor(int descriptor) : descriptor_(descriptor) {}
  FileDescriptor(FileDescriptor&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~FileDescriptor();
  int get() const { return descriptor_; }
  explicit operator bool() const { return descriptor_ >= 0; }

private:
  int descriptor_ = -1;
};

/// Opens a file, closed in the workers that are started later. New files are the owner's alone.
/// @throws std::system_error
FileDescriptor open_file(const std::filesystem::path& path, int flags);

/// Reads up to bytes.size() bytes. @return how many; 0 at the end of the file.
/// @throws std::system_error
std::size_t read_at(int descriptor, std::int64_t offset, std::span<char> bytes);

/// @return bytes in an open file @throws std::system_error
std::int64_t size_of_file(int descriptor);

/// The whole content of a file. @throws std::system_error
std::string read_file(const std::filesystem::path& path);

/// Writes all of `bytes`. @throws std::system_error; some bytes may have been written then.
void write_at(int descriptor, std::int64_t offset, std::string_view bytes);

/// Makes a file's content survive a crash of the machine. @throws std::system_error
void sync_file(int descriptor);

/// Makes names in a directory survive a crash of the machine. @throws std::system_error
void sync_directory(const std::filesystem::path& directory);

/// Creates a file whose content survives a crash; its name does after sync_directory().
/// @throws std::system_error
void write_durably(const std::filesystem::path& path, std::string_view content);

/// Replaces a file: readers see the old content or the new, never a part. @throws std::system_error
void replace_file(const std::filesystem::path& path, std::string_view content);

}  // namespace dccast::jobs
