// Files that dccastd writes stay readable, byte by byte. Event logs of version 1: server/state.
#include <gtest/gtest.h>

#include "core/storage/file.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/logs/event_log.hpp"
#include "tests/support/from_hex.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

/// "started" at second 1, step 7 at second 2.
const std::string event_log = from_hex(
    "44434341 53544556 02000000 00000000 13000000 f2b5f1c3 08011202 08011a0b"
    "08021207 73746172 74656413 00000028 f75dbb08 02120208 02220b08 07110000"
    "00000000 0440");

const std::string description = from_hex(
    "44434341 53544a44 01000000 00000000 2d000000 3b3876f2 010a2430 64366333"
    "6135322d 38663565 2d346331 622d3966 34652d32 61376231 63336435 65366612"
    "04627574 740a0000 00f58c8b 29017375 626d6974 74656401 00000052 d016a001");

TEST(EarlierFiles, AnEventLogIsReadAndGoneOnWith) {
  const TemporaryFolder folder;
  storage::write_file(folder / "events.log", event_log);
  {
    EventLog log(folder / "events.log");
    EXPECT_TRUE(log.content().gaps.empty());
    EXPECT_EQ(log.last_sequence(), 2);
    EXPECT_EQ(log.content().last_state->state(), v1::RUNNING);
    EXPECT_EQ(log.content().reached_step, 7);
    EventLog::Cursor cursor;
    EXPECT_EQ(log.read(cursor)->state_change().cause(), "started");
    EXPECT_EQ(log.read(cursor)->step().time_s(), 2.5);
    v1::JobEvent next;
    next.mutable_step()->set_step(8);
    log.append(next);
  }
  EXPECT_TRUE(storage::read_file(folder / "events.log").starts_with(event_log));
  EXPECT_EQ(EventLog(folder / "events.log").last_sequence(), 3);
}

TEST(EarlierFiles, AnEventLogIsWrittenWithTheSameBytes) {
  const TemporaryFolder folder;
  {
    EventLog log(folder / "events.log");
    v1::Job job;
    job.set_state(v1::RUNNING);
    v1::JobEvent started = state_event(job, "started");
    *started.mutable_time() = timestamp(1000);
    log.append(started);
    v1::JobEvent step;
    step.mutable_step()->set_step(7);
    step.mutable_step()->set_time_s(2.5);
    *step.mutable_time() = timestamp(2000);
    log.append(step);
  }
  EXPECT_EQ(storage::read_file(folder / "events.log"), event_log);
}

TEST(EarlierFiles, AJobDescriptionIsRead) {
  const TemporaryFolder folder;
  storage::write_file(folder / description_file, description);
  const JobDescription read = read_job_description(folder.path());
  EXPECT_EQ(read.job.title(), "butt");
  EXPECT_EQ(read.submitted_case, "submitted");
  EXPECT_EQ(read.complete_case, "");
  EXPECT_TRUE(read.attachment_sha256.empty());
}

}  // namespace
}  // namespace dccast::jobs
