#include "core/storage/storage_error.hpp"

#include <algorithm>
#include <array>
#include <cerrno>

namespace dccast::storage {

namespace {

constexpr std::array disk_faults{ENOSPC, EDQUOT, EROFS, EIO, EFBIG};
constexpr std::array shortages{EMFILE, ENFILE, ENOMEM, EAGAIN};

template <std::size_t count>
bool contains(const std::array<int, count>& codes, int code) {
  return std::find(codes.begin(), codes.end(), code) != codes.end();
}

}  // namespace

bool is_disk_fault(const std::error_code& code) {
  return contains(disk_faults, code.value());
}

bool is_resource_fault(const std::error_code& code) {
  return is_disk_fault(code) || contains(shortages, code.value());
}

}  // namespace dccast::storage
