#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/storage/file.hpp"

namespace dccast::storage {

/// Buffered reads at any place of a file, efficient for sequential reading. Data appended after
/// construction are not seen.
class FileWindow {
public:
  /// @param file  must outlive this object
  explicit FileWindow(const File& file) : file_(file), size_(file.size()) {}

  std::int64_t size() const { return size_; }  ///< [bytes]

  /// Bytes from `offset` on, fewer at the end of the file; valid until the next call.
  /// @throws StorageError
  std::string_view at(std::int64_t offset, std::int64_t length);

private:
  void fill(std::int64_t offset, std::int64_t length);

  const File& file_;
  std::int64_t size_;
  std::int64_t begin_ = 0;  ///< offset of bytes_ in the file
  std::string bytes_;
};

}  // namespace dccast::storage
