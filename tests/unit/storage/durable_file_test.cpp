#include "core/storage/file.hpp"

#include <gtest/gtest.h>

#include "core/storage/storage_error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::storage {
namespace {

namespace fs = std::filesystem;

fs::perms permissions_of(const fs::path& path) {
  return fs::status(path).permissions();
}

TEST(DurableFile, IsReplacedAndLeavesNoTemporary) {
  const TemporaryFolder folder;
  replace_file(folder / "f", "old");
  replace_file(folder / "f", "new");
  EXPECT_EQ(read_file(folder / "f"), "new");
  EXPECT_FALSE(fs::exists(folder / "f.tmp"));
}

TEST(DurableFile, IsTheOwnersUnlessSaidOtherwise) {
  const TemporaryFolder folder;
  replace_file(folder / "own", "");
  replace_file(folder / "all", "", readable_by_all);
  EXPECT_EQ(permissions_of(folder / "own"), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_NE(permissions_of(folder / "all") & fs::perms::others_read, fs::perms::none);
}

TEST(DurableFile, IsCreatedOnce) {
  const TemporaryFolder folder;
  create_durably(folder / "f", "first");
  EXPECT_THROW(create_durably(folder / "f", "second"), StorageError);
  EXPECT_EQ(read_file(folder / "f"), "first");
}

TEST(DurableFile, IsPublishedWithItsCompanions) {
  const TemporaryFolder folder;
  write_file(folder / "a.part", "a");
  write_file(folder / "b.part", "b");
  publish({{folder / "a.part", folder / "a"}, {folder / "b.part", folder / "b"}});
  EXPECT_EQ(read_file(folder / "a") + read_file(folder / "b"), "ab");
  EXPECT_FALSE(fs::exists(folder / "a.part"));
}

TEST(File, NamesItselfWhenItIsNotThere) {
  const TemporaryFolder folder;
  try {
    read_file(folder / "none");
    FAIL();
  } catch (const StorageError& error) {
    EXPECT_EQ(error.code(), std::errc::no_such_file_or_directory);
    EXPECT_NE(std::string(error.what()).find("none: cannot be opened"), std::string::npos);
  }
}

}  // namespace
}  // namespace dccast::storage
