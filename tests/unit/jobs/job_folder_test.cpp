#include "server/jobs/job_folder.hpp"

#include <gtest/gtest.h>

#include "tests/unit/jobs/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

TEST(PlainFileName, IsOneComponentOfAPath) {
  EXPECT_TRUE(is_plain_file_name("slab.msh"));
  EXPECT_TRUE(is_plain_file_name("..slab"));
  for (const std::string& name :
       {std::string(), std::string("."), std::string(".."), std::string("a/b"), std::string("/a"),
        std::string("a\0b", 3), std::string(256, 'x')})
    EXPECT_FALSE(is_plain_file_name(name)) << name;
}

TEST(CheckFolder, HoldsTheAttachmentsAndIsGoneAfterwards) {
  const TemporaryFolder parent;
  Attachments attachments;
  attachments.Add()->set_name("mesh");
  std::filesystem::path path;
  {
    const CheckFolder folder(parent.path(), attachments);
    path = folder.path();
    EXPECT_TRUE(std::filesystem::exists(path / attachments_folder / "mesh"));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(JobFolder, LeavesNothingBehindWhenItFails) {
  const TemporaryFolder parent;
  Attachments attachments;
  attachments.Add()->set_name("same");
  attachments.Add()->set_name("same");
  EXPECT_THROW(create_job_folder(parent.path() / "job", attachments), std::system_error);
  EXPECT_FALSE(std::filesystem::exists(parent.path() / "job"));
}

}  // namespace
}  // namespace dccast::jobs
