#include "core/storage/storage_error.hpp"

#include <algorithm>
#include <array>
#include <cerrno>

namespace dccast::storage {

namespace {

constexpr std::array disk_faults{ENOSPC, EDQUOT, EROFS, EIO, EFBIG};
constexpr std::array lack_of_memory{ENOMEM, EAGAIN};
constexpr std::array lack_of_descriptors{EMFILE, ENFILE};

template <std::size_t count>
bool contains(const std::array<int, count>& codes, int code) {
  return std::find(codes.begin(), codes.end(), code) != codes.end();
}

}  // namespace

bool is_disk_fault(const std::error_code& code) {
  return contains(disk_faults, code.value());
}

bool is_memory_fault(const std::error_code& code) {
  return contains(lack_of_memory, code.value());
}

bool is_resource_fault(const std::error_code& code) {
  return is_disk_fault(code) || is_memory_fault(code) ||
         contains(lack_of_descriptors, code.value());
}

}  // namespace dccast::storage
