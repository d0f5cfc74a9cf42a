#include "server/jobs/folder/result_files.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "proto/values/digests.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

namespace fs = std::filesystem;

class ResultFiles : public testing::Test {
protected:
  ResultFiles() {
    artifact_.set_name("results.h5");
    artifact_.set_size_bytes(7);
    artifact_.set_sha256(values::sha256("results"));
    storage::write_file(path(), "results");
  }
  fs::path path() const { return folder_.path() / "results.h5"; }

  /// Why it is refused; empty: it is sound.
  std::string fault() {
    try {
      digests_.require_sound(folder_.path(), artifact_);
      return {};
    } catch (const UnsoundResult& unsound) {
      return unsound.what();
    }
  }
  void expect_fault(const std::string& part) {
    const std::string text = fault();
    EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_NE(text.find("run the job again"), std::string::npos) << text;
    EXPECT_EQ(text.find(folder_.path().string()), std::string::npos) << text;
  }

  const TemporaryFolder folder_;
  v1::Artifact artifact_;
  ResultDigests digests_;
};

TEST_F(ResultFiles, WhatTheWorkerWroteIsSoundUntilItChanges) {
  EXPECT_EQ(fault(), "");
  EXPECT_EQ(fault(), "");
  storage::write_file(path(), "resulta");
  expect_fault("SHA-256");
  storage::write_file(path(), "results");
  EXPECT_EQ(fault(), "");
}

TEST_F(ResultFiles, AChangeThatSetsTheTimeBackIsNoticed) {
  EXPECT_EQ(fault(), "");
  const auto time = fs::last_write_time(path());
  storage::write_file(path(), "resulta");
  fs::last_write_time(path(), time);
  expect_fault("SHA-256");
}

TEST_F(ResultFiles, WhatCannotBeReadIsRefusedWithoutItsFolder) {
  storage::write_file(path(), "result");
  expect_fault("size");

  fs::remove(path());
  expect_fault("cannot be read");

  fs::create_directory(path());
  expect_fault("cannot be read");

  fs::remove(path());
  ASSERT_EQ(::mkfifo(path().c_str(), 0600), 0);
  expect_fault("cannot be read");

  fs::remove(path());
  storage::write_file(folder_.path() / "elsewhere", "results");
  fs::create_symlink(folder_.path() / "elsewhere", path());
  expect_fault("cannot be read");
  EXPECT_THROW(open_result(folder_.path(), artifact_), UnsoundResult);
}

}  // namespace
}  // namespace dccast::jobs
