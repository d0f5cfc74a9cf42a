#include "core/storage/file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

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

/// Message of a failure to open this file; empty if it opens.
std::string refusal_of(const fs::path& path, int flags) {
  try {
    const File opened(path, flags);
    return "";
  } catch (const StorageError& error) {
    return error.what();
  }
}

/// A named pipe would keep its reader waiting for a writer, for ever.
TEST(File, IsNoNamedPipe) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const int flags : {O_RDONLY, O_RDWR, O_RDWR | O_CREAT, O_WRONLY})
    EXPECT_NE(refusal_of(folder / "pipe", flags).find("pipe: is a named pipe, not a regular file"),
              std::string::npos)
        << refusal_of(folder / "pipe", flags);
}

TEST(File, IsNoLinkAndNoFolder) {
  const TemporaryFolder folder;
  write_file(folder / "elsewhere", "of another");
  fs::create_symlink("elsewhere", folder / "link");
  fs::create_symlink("nowhere", folder / "dangling");
  fs::create_directory(folder / "folder");

  for (const int flags : {O_RDONLY, O_RDWR, O_WRONLY | O_CREAT | O_TRUNC}) {
    EXPECT_NE(refusal_of(folder / "link", flags).find("is a symbolic link, not a regular file"),
              std::string::npos);
    EXPECT_NE(refusal_of(folder / "dangling", flags).find("is a symbolic link"), std::string::npos);
    EXPECT_NE(refusal_of(folder / "folder", flags).find("is a folder, not a regular file"),
              std::string::npos);
  }
  EXPECT_EQ(read_file(folder / "elsewhere"), "of another");
  EXPECT_FALSE(fs::exists(folder / "nowhere"));
  EXPECT_EQ(kind_of_entry(folder / "link"), "a symbolic link");
  EXPECT_EQ(kind_of_entry(folder / "elsewhere"), "a regular file");
  EXPECT_EQ(kind_of_entry(folder / "none"), "");
}

/// The certificate of a server may well be one: an administrator has named it.
TEST(File, FollowsALinkThatAPersonNamed) {
  const TemporaryFolder folder;
  write_file(folder / "real", "content");
  fs::create_symlink("real", folder / "link");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(read_file(folder / "link", Links::follow), "content");
  EXPECT_THROW(read_file(folder / "pipe", Links::follow), StorageError);
}

TEST(DurableFile, IsReplacedPastALinkAtItsTemporaryName) {
  const TemporaryFolder folder;
  write_file(folder / "victim", "of another");
  fs::create_symlink("victim", folder / "f.tmp");
  replace_file(folder / "f", "new");
  EXPECT_EQ(read_file(folder / "victim"), "of another");
  EXPECT_EQ(read_file(folder / "f"), "new");
}

}  // namespace
}  // namespace dccast::storage
