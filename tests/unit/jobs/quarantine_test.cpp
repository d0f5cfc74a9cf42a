#include "server/jobs/folder/quarantine.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "proto/values/digests.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

namespace fs = std::filesystem;

class QuarantineTest : public testing::Test {
protected:
  QuarantineTest() { fs::create_directory(jobs_); }
  std::string make_folder() const {
    const std::string id = values::random_uuid();
    fs::create_directory(jobs_ / id);
    std::ofstream(jobs_ / id / "results.h5") << id;
    return id;
  }
  TemporaryFolder folder_;
  fs::path jobs_ = folder_.path() / "jobs";
};

TEST_F(QuarantineTest, TakesFoldersWithoutAJobAndNoOthers) {
  const std::string known = make_folder();
  const std::string unknown = make_folder();
  fs::create_directory(jobs_ / "notes of an engineer");
  quarantine_unknown_folders(jobs_, {known});
  EXPECT_TRUE(fs::exists(jobs_ / known));
  EXPECT_FALSE(fs::exists(jobs_ / unknown));
  EXPECT_TRUE(fs::exists(jobs_ / "notes of an engineer"));
  const auto moved = quarantined_folders(jobs_);
  ASSERT_EQ(moved.size(), 1u);
  EXPECT_EQ(moved[0].id, unknown);
  EXPECT_TRUE(fs::exists(moved[0].path / "results.h5"));
}

TEST_F(QuarantineTest, WhatStandsInItsPlaceIsSetAside) {
  const fs::path quarantine = folder_.path() / "quarantine";
  std::ofstream(quarantine) << "no folder";
  EXPECT_TRUE(quarantined_folders(jobs_).empty());
  const std::string unknown = make_folder();
  quarantine_unknown_folders(jobs_, {});
  ASSERT_EQ(quarantined_folders(jobs_).size(), 1u);
  EXPECT_EQ(quarantined_folders(jobs_)[0].id, unknown);
  EXPECT_TRUE(fs::exists(quarantine.string() + ".strange"));
}

TEST_F(QuarantineTest, GivesBackTheNewestFolderOfAJob) {
  const std::string id = make_folder();
  quarantine_folder(jobs_, id);
  fs::create_directory(jobs_ / id);  // the same job once more, within the same second
  std::ofstream(jobs_ / id / "newer") << "x";
  quarantine_folder(jobs_, id);
  EXPECT_EQ(quarantined_folders(jobs_).size(), 2u);
  EXPECT_TRUE(release_folder(jobs_, id));
  EXPECT_TRUE(fs::exists(jobs_ / id / "newer"));
  EXPECT_FALSE(release_folder(jobs_, id)) << "the name is taken";
  EXPECT_FALSE(release_folder(jobs_, values::random_uuid()));
}

// A crash between the two halves of a deletion: the store decides.
TEST_F(QuarantineTest, ADeletionThatWasCutShortIsEndedOrUndone) {
  const std::string kept = make_folder();
  const std::string deleted = make_folder();
  EXPECT_TRUE(begin_removal(jobs_, kept));
  EXPECT_TRUE(begin_removal(jobs_, deleted));
  EXPECT_TRUE(folder_ids(jobs_).empty());
  quarantine_unknown_folders(jobs_, {kept});
  EXPECT_TRUE(quarantined_folders(jobs_).empty());
  EXPECT_EQ(folder_ids(jobs_), std::set<std::string>{kept});
  EXPECT_EQ(std::distance(fs::directory_iterator(jobs_), {}), 1);
  EXPECT_FALSE(begin_removal(jobs_, deleted));
}

}  // namespace
}  // namespace dccast::jobs
