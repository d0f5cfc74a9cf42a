#include "core/storage/record_log.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include "core/storage/storage_error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::storage {
namespace {

File opened(const std::filesystem::path& path) {
  return {path, O_RDWR | O_CREAT};
}

TEST(RecordLog, GoesOnBehindWhatItFinds) {
  const TemporaryFolder folder;
  write_file(folder / "log", "one");
  RecordLog log(opened(folder / "log"));
  EXPECT_EQ(log.append("two"), 3);
  EXPECT_EQ(log.end(), 6);
  log.sync();
  log.cut(3);
  EXPECT_EQ(log.append("three"), 3);
  log.sync();
  EXPECT_EQ(read_file(folder / "log"), "onethree");
}

TEST(RecordLog, StaysAsItWasWhenAWriteFails) {
  const TemporaryFolder folder;
  RecordLog log(opened(folder / "log"));
  log.append("one");
  ::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 5;  // a part of the next record fits
  ::setrlimit(RLIMIT_FSIZE, &small);
  EXPECT_THROW(log.append("two"), StorageError);

  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(read_file(folder / "log"), "one");
  EXPECT_EQ(log.append("three"), 3);
  EXPECT_EQ(read_file(folder / "log"), "onethree");
}

// The kernel may have dropped what a sync could not write: a log that continued would have a hole.
TEST(RecordLog, TakesNothingMoreAfterAFailedSync) {
  const TemporaryFolder folder;
  RecordLog log(opened(folder / "log"));
  log.append("one");
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ASSERT_GE(::dup2(ends[1], log.file().descriptor()), 0);  // a pipe cannot be synchronised
  EXPECT_THROW(log.sync(), StorageError);
  EXPECT_THROW(log.append("two"), StorageError);
  ::close(ends[0]);
  ::close(ends[1]);
}

}  // namespace
}  // namespace dccast::storage
