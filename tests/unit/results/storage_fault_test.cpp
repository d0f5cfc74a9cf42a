// A disk that is full, played by a limit on the size of files in a process of its own.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <functional>
#include <iostream>

#include "core/results/checkpoint_file.hpp"
#include "core/storage/storage_error.hpp"
#include "tests/unit/results/sample_run.hpp"

namespace dccast::results {
namespace {

constexpr int told = 17;    ///< the exit code of a process that was told of the fault
constexpr int untold = 18;  ///< ... that was not

void limit_file_size(rlim_t bytes) {
  ::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{bytes, bytes};
  ::setrlimit(RLIMIT_FSIZE, &limit);
}

/// Exit code of a process that runs `work` with files of at most `bytes`.
int outcome_with_limit(rlim_t bytes, const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    limit_file_size(bytes);
    try {
      work();
    } catch (const std::system_error& error) {
      std::cerr << error.what() << '\n';
      ::_exit(error.code().value() == EFBIG ? told : untold);
    }
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(FullDisk, IsReportedByTheJournal) {
  const TemporaryFolder folder;
  EXPECT_EQ(
      outcome_with_limit(4000,
                         [&] {
                           ResultWriter writer({folder / "j", folder / "r.h5"}, sample_header());
                           writer.append(sample_frame(0, 3, 400));
                           writer.flush();
                         }),
      told);
}

TEST(FullDisk, IsReportedByTheResultFileWhichDoesNotAppear) {
  const TemporaryFolder folder;
  const RunFiles files{folder / "j", folder / "r.h5"};
  {
    ResultWriter writer(files, sample_header());
    for (int i = 0; i < 20; ++i) writer.append(sample_frame(i, 3, 400));
    writer.flush();
  }
  const auto publish = [&] {
    ResultWriter::resume(files, {sample_step(19)}, 21).writer->publish({});
  };

  EXPECT_EQ(outcome_with_limit(20000, publish), told);
  EXPECT_FALSE(std::filesystem::exists(folder / "r.h5"));

  publish();  // the disk has room again: nothing is lost
  EXPECT_TRUE(std::filesystem::exists(folder / "r.h5"));
}

TEST(FullDisk, LeavesThePreviousCheckpoint) {
  const TemporaryFolder folder;
  Sections content;
  content.set_integer("step", 7);
  write_checkpoint(folder / "c", content);
  content.set("displacement", Sections::Reals(1000, 1.0));
  EXPECT_EQ(outcome_with_limit(4000, [&] { write_checkpoint(folder / "c", content); }), told);
  EXPECT_EQ(read_checkpoint(folder / "c").content->integer("step"), 7);
}

TEST(MissingFolder, IsNamed) {
  const TemporaryFolder folder;
  try {
    ResultWriter writer({folder / "none/j", folder / "none/r.h5"}, sample_header());
    FAIL() << "written to a folder that is not there";
  } catch (const storage::StorageError& error) {
    EXPECT_EQ(error.code().value(), ENOENT);
    EXPECT_NE(std::string(error.what()).find("none/j"), std::string::npos);
  }
}

}  // namespace
}  // namespace dccast::results
