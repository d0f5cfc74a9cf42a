#include "server/studies/study_file.hpp"

#include <gtest/gtest.h>

#include "core/storage/file.hpp"
#include "server/jobs/folder/format.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::studies {
namespace {

const std::string id = "0d6c3a52-8f5e-4c1b-9f4e-2a7b1c3d5e6f";

TEST(StudyFile, OfAnotherFormatIsRefused) {
  const TemporaryFolder folder;
  StudyRecord record;
  record.id = id;
  record.case_sha256 = "ab12";
  record.request.set_request_id("curl");
  write_study_file(folder.path(), record);
  EXPECT_EQ(read_study_file(folder.path(), id).id, id);

  const auto path = study_file(folder.path(), id);
  std::string bytes = storage::read_file(path);
  bytes[8] = bytes[12] = 2;
  storage::write_file(path, bytes);
  EXPECT_THROW(read_study_file(folder.path(), id), jobs::OtherFormat);
}

TEST(StudyFile, AttachmentsWithNeitherRowNorFileAreRemoved) {
  const TemporaryFolder folder;
  const auto attachments = attachments_of_study(folder.path(), id);
  std::filesystem::create_directories(attachments);
  remove_orphaned_attachments(folder.path(), {id});
  EXPECT_TRUE(std::filesystem::exists(attachments));
  remove_orphaned_attachments(folder.path(), {});
  EXPECT_FALSE(std::filesystem::exists(attachments));
}

}  // namespace
}  // namespace dccast::studies
