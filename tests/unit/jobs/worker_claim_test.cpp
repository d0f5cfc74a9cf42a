#include "server/jobs/executors/worker_claim.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/jobs/claiming_process.hpp"

namespace dccast::jobs {
namespace {

namespace fs = std::filesystem;

TEST(WorkerClaim, NamesTheProcessThatHasTheFolder) {
  const TemporaryFolder folder;
  EXPECT_FALSE(find_holder(folder.path())) << "nobody has ever claimed it";
  ClaimingProcess worker(folder.path(), {.job_id = "a-job", .attempt = 3});
  const auto holder = find_holder(folder.path());
  ASSERT_TRUE(holder);
  EXPECT_EQ(holder->process, worker.id());
  ASSERT_TRUE(holder->claim);
  EXPECT_EQ(holder->claim->job_id, "a-job");
  EXPECT_EQ(holder->claim->attempt, 3);
  EXPECT_EQ(holder->claim->protocol, worker_protocol);
  EXPECT_TRUE(find_holder(folder.path())) << "to look is not to take";
}

TEST(WorkerClaim, EndsWithItsProcess) {
  const TemporaryFolder folder;
  {
    ClaimingProcess worker(folder.path(), {.job_id = "a-job", .attempt = 1});
    EXPECT_THROW(FolderClaim(folder.path(), {.job_id = "a-job", .attempt = 2},
                             std::chrono::milliseconds(20)),
                 FolderTaken);
    EXPECT_TRUE(find_holder(folder.path())) << "a refused one takes nothing away";
  }
  EXPECT_FALSE(find_holder(folder.path()));
  EXPECT_NO_THROW(
      FolderClaim(folder.path(), {.job_id = "a-job", .attempt = 2}, std::chrono::milliseconds(0)));
}

TEST(WorkerClaim, WaitsForAWorkerThatIsAboutToEnd) {
  const TemporaryFolder folder;
  auto worker = std::make_unique<ClaimingProcess>(folder.path(),
                                                  WorkerClaim{.job_id = "a-job", .attempt = 1});
  worker->kill_soon();
  EXPECT_NO_THROW(
      FolderClaim(folder.path(), {.job_id = "a-job", .attempt = 2}, std::chrono::seconds(10)));
}

TEST(WorkerClaim, DoesNotUnderstandATextThatIsNotWhole) {
  const TemporaryFolder folder;
  ClaimingProcess worker(folder.path(), {.job_id = "a-job", .attempt = 1});
  for (const char* text : {"", "1 1 a-job", "one 1 a-job\n", "1 1\n"}) {
    std::ofstream(folder / "worker.lock") << text;
    const auto holder = find_holder(folder.path());
    ASSERT_TRUE(holder) << text;
    EXPECT_FALSE(holder->claim) << text;
  }
}

TEST(WorkerClaim, StandsUntilTheFolderGoesOrIsPutBack) {
  const TemporaryFolder parent;
  const fs::path folder = parent / "job";
  fs::create_directory(folder);
  const FolderClaim claim(folder, {.job_id = "a-job", .attempt = 1}, std::chrono::seconds(0));
  EXPECT_EQ(claim.loss(), "");
  fs::rename(folder, parent / "elsewhere");
  EXPECT_NE(claim.loss(), "");
  fs::copy(parent / "elsewhere", folder, fs::copy_options::recursive);
  EXPECT_NE(claim.loss(), "") << "a copy";
}

TEST(WorkerClaim, IsTheOwnersAlone) {
  const TemporaryFolder folder;
  const FolderClaim claim(folder.path(), {.job_id = "a-job", .attempt = 1},
                          std::chrono::seconds(0));
  struct stat file {};
  ASSERT_EQ(::stat((folder / "worker.lock").c_str(), &file), 0);
  EXPECT_EQ(file.st_mode & 0777, 0600u);
}

}  // namespace
}  // namespace dccast::jobs
