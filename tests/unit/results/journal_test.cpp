#include "core/results/journal.hpp"

#include <gtest/gtest.h>

#include "core/storage/file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::results {
namespace {

Sections content_of(std::int64_t step) {
  Sections content;
  content.set_integer("step", step);
  content.set("reals", Sections::Reals{1.0 / 3.0, -0.0});
  return content;
}

std::vector<Record> records_of(const std::filesystem::path& path) {
  std::vector<Record> records;
  EXPECT_TRUE(visit_journal(path, [&](const Record& record) {
    records.push_back(record);
    return true;
  }));
  return records;
}

TEST(Journal, ReturnsWhatWasAppended) {
  const TemporaryFolder folder;
  Journal journal(folder / "j");
  journal.append(RecordKind::header, {});
  journal.append(RecordKind::frame, content_of(3));
  journal.append(RecordKind::frame, content_of(4));
  journal.write();
  journal.sync();
  const auto records = records_of(folder / "j");

  ASSERT_EQ(records.size(), 3u);
  EXPECT_EQ(records[0].kind, RecordKind::header);
  EXPECT_EQ(records[1].kind, RecordKind::frame);
  EXPECT_EQ(records[2].kind, RecordKind::frame);
  EXPECT_EQ(encode(records[2].content), encode(content_of(4)));
  EXPECT_EQ(records[2].end, static_cast<std::int64_t>(std::filesystem::file_size(folder / "j")));
}

TEST(Journal, GoesOnBehindTheByteItIsCutAt) {
  const TemporaryFolder folder;
  {
    Journal journal(folder / "j");
    for (const std::int64_t step : {1, 2, 3}) journal.append(RecordKind::frame, content_of(step));
    journal.write();
  }
  {
    Journal journal(folder / "j", records_of(folder / "j")[1].end);
    journal.append(RecordKind::frame, content_of(2));
    journal.write();
  }
  const auto records = records_of(folder / "j");

  ASSERT_EQ(records.size(), 3u);
  EXPECT_EQ(records[1].content.integer("step"), 2);
  EXPECT_EQ(records[2].kind, RecordKind::frame);
}

TEST(Journal, IsReadOnBehindARecordVisitedBefore) {
  const TemporaryFolder folder;
  Journal journal(folder / "j");
  for (const std::int64_t step : {1, 2, 3}) journal.append(RecordKind::frame, content_of(step));
  journal.write();
  std::vector<std::int64_t> steps;
  visit_journal(
      folder / "j",
      [&](const Record& record) {
        steps.push_back(record.content.integer("step"));
        return true;
      },
      records_of(folder / "j")[0].end);
  EXPECT_EQ(steps, (std::vector<std::int64_t>{2, 3}));
}

TEST(Journal, EndsBeforeARecordThatWasBeingWritten) {
  const TemporaryFolder folder;
  Journal journal(folder / "j");
  journal.append(RecordKind::frame, content_of(1));
  journal.write();
  const auto whole = std::filesystem::file_size(folder / "j");
  journal.append(RecordKind::frame, content_of(2));
  journal.write();
  const auto longer = std::filesystem::file_size(folder / "j");
  for (auto size = longer - 1; size >= whole; --size) {
    std::filesystem::resize_file(folder / "j", size);
    EXPECT_EQ(records_of(folder / "j").size(), 1u) << "cut to " << size;
  }
}

TEST(Journal, EndsBeforeADamagedRecord) {
  const TemporaryFolder folder;
  Journal journal(folder / "j");
  for (const std::int64_t step : {1, 2}) journal.append(RecordKind::frame, content_of(step));
  journal.write();
  const auto first = static_cast<std::size_t>(records_of(folder / "j")[0].end);
  const std::string whole = storage::read_file(folder / "j");
  for (std::size_t at = first; at < whole.size(); ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    storage::write_file(folder / "k", bytes);
    EXPECT_EQ(records_of(folder / "k").size(), 1u) << "byte " << at;
  }
}

TEST(Journal, RefusesAForeignFile) {
  const TemporaryFolder folder;
  storage::write_file(folder / "j", "something else altogether");
  EXPECT_FALSE(visit_journal(folder / "j", [](const Record&) { return true; }));
}

}  // namespace
}  // namespace dccast::results
