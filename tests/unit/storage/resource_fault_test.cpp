#include "core/storage/storage_error.hpp"

#include <gtest/gtest.h>

namespace dccast::storage {
namespace {

TEST(ResourceFault, IsTheDisksOrAShortage) {
  for (const std::errc code :
       {std::errc::no_space_on_device, std::errc::io_error, std::errc::read_only_file_system}) {
    EXPECT_TRUE(is_disk_fault(std::make_error_code(code)));
    EXPECT_TRUE(is_resource_fault(std::make_error_code(code)));
  }
  for (const std::errc code : {std::errc::too_many_files_open, std::errc::not_enough_memory}) {
    EXPECT_FALSE(is_disk_fault(std::make_error_code(code)));
    EXPECT_TRUE(is_resource_fault(std::make_error_code(code)));
  }
  EXPECT_FALSE(is_memory_fault(std::make_error_code(std::errc::too_many_files_open)));
  EXPECT_TRUE(is_memory_fault(std::make_error_code(std::errc::not_enough_memory)));
  EXPECT_TRUE(is_memory_fault(std::make_error_code(std::errc::resource_unavailable_try_again)));
  EXPECT_FALSE(is_resource_fault(std::make_error_code(std::errc::permission_denied)));
  EXPECT_FALSE(is_resource_fault(std::make_error_code(std::errc::no_such_file_or_directory)));
  EXPECT_FALSE(is_resource_fault({}));
}

}  // namespace
}  // namespace dccast::storage
