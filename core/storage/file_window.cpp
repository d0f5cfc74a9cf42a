#include "core/storage/file_window.hpp"

#include <algorithm>

namespace dccast::storage {

namespace {

constexpr std::int64_t piece = 1 << 18;  // read at once at least [bytes]

}  // namespace

std::string_view FileWindow::at(std::int64_t offset, std::int64_t length) {
  length = std::clamp<std::int64_t>(length, 0, std::max<std::int64_t>(size_ - offset, 0));
  if (offset < begin_ || offset + length > begin_ + static_cast<std::int64_t>(bytes_.size()))
    fill(offset, std::max(length, piece));
  const auto have = static_cast<std::int64_t>(bytes_.size()) - (offset - begin_);
  return std::string_view(bytes_).substr(static_cast<std::size_t>(offset - begin_),
                                         static_cast<std::size_t>(std::min(length, have)));
}

void FileWindow::fill(std::int64_t offset, std::int64_t length) {
  begin_ = offset;
  bytes_.resize(static_cast<std::size_t>(length));
  bytes_.resize(file_.read_at(offset, bytes_));
}

}  // namespace dccast::storage
