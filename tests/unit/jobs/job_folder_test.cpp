#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/logs/event_log_scan.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/logs/event_log.hpp"
#include "tests/support/temporary_folder.hpp"

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

/// A file of the folder, under a name of a case.
AttachedFile attached(const TemporaryFolder& folder, const std::string& name,
                      const std::string& content) {
  const auto path = folder.path() / "uploaded";
  storage::write_file(path, content);
  return {.name = name, .sha256 = values::sha256(content), .bytes = 3, .path = path};
}

TEST(CheckFolder, HoldsTheAttachmentsAndIsGoneAfterwards) {
  const TemporaryFolder parent;
  const Attachments attachments{attached(parent, "mesh", "abc")};
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
  const Attachments attachments(2, attached(parent, "same", "abc"));
  EXPECT_THROW(create_job_folder(parent.path() / "job", attachments, {}), std::system_error);
  EXPECT_FALSE(std::filesystem::exists(parent.path() / "job"));
}

JobDescription description() {
  JobDescription description;
  description.job.set_id("an id");
  description.job.set_owner("who submitted it");
  description.submitted_case = "";  // a case of defaults only
  description.complete_case = std::string("complete\0case", 13);
  return description;
}

void expect_whole(const JobDescription& read) {
  EXPECT_EQ(read.job.id(), "an id");
  EXPECT_EQ(read.job.owner(), "who submitted it");
  EXPECT_EQ(read.submitted_case, "");
  EXPECT_EQ(read.complete_case, description().complete_case);
}

TEST(JobFolder, SaysWhatItsJobIsWithTheDigestsOfItsAttachments) {
  const TemporaryFolder parent;
  const auto folder = parent.path() / "job";
  create_job_folder(folder, {attached(parent, "a mesh", "abc")}, description());
  const JobDescription read = read_job_description(folder);
  expect_whole(read);
  EXPECT_EQ(read.attachment_sha256.at("a mesh"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(JobFolder, RequiresEachFileThatItsDescriptionNames) {
  const TemporaryFolder parent;
  const auto folder = parent.path() / "job";
  JobDescription described = description();
  described.files = {"readings.log"};
  create_job_folder(folder, {attached(parent, "a mesh", "abc")}, described);
  storage::write_file(folder / "readings.log", "a record");
  const JobDescription read = read_job_description(folder);
  EXPECT_EQ(read.files, described.files);
  EXPECT_NO_THROW(require_files(folder, read));

  const auto fault = [&] {
    try {
      require_files_to_run(folder, read);
      return std::string("none");
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
  };
  std::filesystem::remove(folder / "readings.log");
  EXPECT_EQ(fault(), "its readings.log is missing");
  ::mkfifo((folder / "readings.log").c_str(), 0600);
  EXPECT_EQ(fault(), "its readings.log is a named pipe, not a regular file");
  storage::replace_file(folder / "readings.log", "a record");
  EXPECT_EQ(fault(), "none");

  ::mkfifo((folder / claim_file).c_str(), 0600);
  EXPECT_EQ(fault(), "its worker.lock is a named pipe, not a regular file");
  std::filesystem::remove(folder / claim_file);
  std::filesystem::remove(folder / attachments_folder / "a mesh");
  EXPECT_EQ(fault(), "its attachments/a mesh is missing");
}

/// It stands in its file twice.
TEST(JobFolder, ADescriptionIsReadWhereverAByteIsDamaged) {
  const TemporaryFolder parent;
  write_job_description(parent.path(), description());
  const std::string sound = storage::read_file(parent.path() / description_file);
  for (std::size_t byte = 0; byte < sound.size(); ++byte) {
    std::string damaged = sound;
    damaged[byte] = static_cast<char>(damaged[byte] ^ 4);
    storage::replace_file(parent.path() / description_file, damaged);
    expect_whole(read_job_description(parent.path()));
  }
}

TEST(JobFolder, ADescriptionThatIsDamagedTwiceIsRefused) {
  const TemporaryFolder parent;
  write_job_description(parent.path(), description());
  const std::string sound = storage::read_file(parent.path() / description_file);
  const std::size_t half = (sound.size() - 16) / 2;
  for (std::size_t byte = 16; byte < 16 + half; ++byte) {
    std::string damaged = sound;
    for (const std::size_t at : {byte, byte + half})
      damaged[at] = static_cast<char>(damaged[at] ^ 4);
    storage::replace_file(parent.path() / description_file, damaged);
    EXPECT_THROW(read_job_description(parent.path()), std::runtime_error) << byte;
  }
  EXPECT_THROW(read_job_description(parent.path() / "other"), std::runtime_error);
}

TEST(JobFolder, AnAcceptedJobIsToldByItsMarkOrByMoreThanOneEvent) {
  const TemporaryFolder parent;
  const auto folder = parent.path() / "job";
  create_job_folder(folder, {}, description());
  EXPECT_FALSE(was_accepted(folder));

  EventLog log(folder / "events.log");
  for (const bool accepted : {false, true}) {
    v1::JobEvent event = message_event("next", v1::JobEvent::Message::INFO);
    log.append(event);
    EXPECT_EQ(was_accepted(folder), accepted);
  }
  create_job_folder(parent.path() / "other", {}, description());
  mark_accepted(parent.path() / "other");
  EXPECT_TRUE(was_accepted(parent.path() / "other"));
}

}  // namespace
}  // namespace dccast::jobs
