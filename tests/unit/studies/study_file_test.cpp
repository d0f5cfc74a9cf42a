#include "server/studies/study_file.hpp"

#include <gtest/gtest.h>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "tests/support/from_hex.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::studies {
namespace {

/// Format of dccastd before core and server shared their framing.
const std::string earlier = from_hex(
    "44434341 53545344 01000000 00000000 30000000 71532f48 0a243064 36633361"
    "35322d38 6635652d 34633162 2d396634 652d3261 37623163 33643565 36662204"
    "616e6e61 2a020801 06000000 4b30c1cb 0a046375 726c0400 00006130 db026162"
    "3132");

TEST(StudyFile, OfAnEarlierVersionIsRead) {
  const TemporaryFolder folder;
  const std::string id = "0d6c3a52-8f5e-4c1b-9f4e-2a7b1c3d5e6f";
  storage::write_file(study_file(folder.path(), id), earlier);
  const StudyRecord read = read_study_file(folder.path(), id);
  EXPECT_EQ(read.owner, "anna");
  EXPECT_EQ(read.created_ms, 1000);
  EXPECT_EQ(read.request.request_id(), "curl");
  EXPECT_EQ(read.case_sha256, "ab12");

  // It is written as version 2, with the same content.
  write_study_file(folder.path(), read);
  std::string written = earlier;
  written[8] = 2;
  EXPECT_EQ(storage::read_file(study_file(folder.path(), id)), written);
}

/// Until uploads were streamed, a request held the files of its case: field 2 of Attachment.
TEST(StudyFile, FilesInsideARequestOfAnEarlierVersionMoveIntoTheFolder) {
  const TemporaryFolder folder;
  StudyRecord record;
  record.id = "0d6c3a52-8f5e-4c1b-9f4e-2a7b1c3d5e6f";
  ASSERT_TRUE(
      record.request.ParseFromString(std::string("\x1a\x0f\x0a\x08slab.msh\x12\x03"
                                                 "abc")));
  ASSERT_EQ(record.request.attachments(0).name(), "slab.msh");

  EXPECT_TRUE(move_attachments_out(folder.path(), record));
  EXPECT_FALSE(move_attachments_out(folder.path(), record));
  const auto files = study_attachments(folder.path(), record);
  ASSERT_EQ(files.size(), 1U);
  EXPECT_EQ(storage::read_file(files[0].path), "abc");
  EXPECT_EQ(files[0].sha256, values::sha256("abc"));
  EXPECT_EQ(files[0].bytes, 3);

  // A folder with neither row nor file is removed; one with either stays.
  remove_orphaned_attachments(folder.path(), {record.id});
  EXPECT_TRUE(std::filesystem::exists(files[0].path));
  remove_orphaned_attachments(folder.path(), {});
  EXPECT_FALSE(std::filesystem::exists(files[0].path));
}

}  // namespace
}  // namespace dccast::studies
