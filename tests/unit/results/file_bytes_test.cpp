// Journals and checkpoints, byte by byte.
#include <gtest/gtest.h>

#include "core/results/checkpoint_file.hpp"
#include "core/results/journal.hpp"
#include "core/storage/file.hpp"
#include "tests/support/from_hex.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::results {
namespace {

/// A header with title and liquidus, and the frame of step 7.
const std::string journal = from_hex(
    "44434a52 4e4c310a b1d3dabb 37000000 00000000 01020000 00080000 006c6971"
    "75696475 73000100 00000000 00000000 00000048 84400500 00007469 746c6502"
    "04000000 00000000 62757474 80f9f0eb 3f000000 00000000 02020000 00050000"
    "00726561 6c730002 00000000 00000055 55555555 55d53f00 00000000 00008004"
    "00000073 74657001 01000000 00000000 07000000 00000000");

const std::string checkpoint = from_hex(
    "4443434b 50540d0a 01000000 d8c2da5a 3f000000 00000000 02000000 05000000"
    "7265616c 73000200 00000000 00005555 55555555 d53f0000 00000000 00800400"
    "00007374 65700101 00000000 00000007 00000000 000000");

void expect_step_seven(const Sections& content) {
  EXPECT_EQ(content.integer("step"), 7);
  EXPECT_EQ(content.reals("reals"), (Sections::Reals{1.0 / 3.0, -0.0}));
}

TEST(FileBytes, AJournalIsRead) {
  const TemporaryFolder folder;
  storage::write_file(folder / "j", journal);
  std::vector<Record> records;
  ASSERT_TRUE(visit_journal(folder / "j", [&](const Record& record) {
    records.push_back(record);
    return true;
  }));
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[0].kind, RecordKind::header);
  EXPECT_EQ(records[0].content.text("title"), "butt");
  EXPECT_EQ(records[0].content.real("liquidus"), 649.0);
  EXPECT_EQ(records[1].kind, RecordKind::frame);
  expect_step_seven(records[1].content);
  EXPECT_EQ(records[1].end, static_cast<std::int64_t>(journal.size()));
}

TEST(FileBytes, AJournalIsWrittenWithTheSameBytes) {
  const TemporaryFolder folder;
  Sections header, step;
  header.set("title", std::string("butt"));
  header.set_real("liquidus", 649.0);
  step.set_integer("step", 7);
  step.set("reals", Sections::Reals{1.0 / 3.0, -0.0});
  Journal written(folder / "j");
  written.append(RecordKind::header, header);
  written.append(RecordKind::frame, step);
  written.write();
  EXPECT_EQ(storage::read_file(folder / "j"), journal);
}

TEST(FileBytes, ACheckpointIsRead) {
  const TemporaryFolder folder;
  storage::write_file(folder / "c", checkpoint);
  const CheckpointRead read = read_checkpoint(folder / "c");
  ASSERT_TRUE(read.content) << read.reason;
  expect_step_seven(*read.content);
  write_checkpoint(folder / "d", *read.content);
  EXPECT_EQ(storage::read_file(folder / "d"), checkpoint);
}

}  // namespace
}  // namespace dccast::results
