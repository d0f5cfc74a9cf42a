#include "core/storage/record_log.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace dccast::storage {
namespace {

using namespace std::string_literals;

struct Sample {
  const char* name;
  RecordFormat format;
  std::string bytes;  ///< of the payload "step 7" with kind 2

  friend void PrintTo(const Sample& sample, std::ostream* out) { *out << sample.name; }
};

class RecordFormats : public testing::TestWithParam<Sample> {
protected:
  const RecordFormat format = GetParam().format;
  const std::uint8_t kind = format.has_kind ? 2 : 0;
};

INSTANTIATE_TEST_SUITE_P(All, RecordFormats,
                         testing::Values(Sample{"Short", short_records,
                                                "\x06\0\0\0\xaa\xd2\x31\x7c"
                                                "step 7"s},
                                         Sample{"Long", long_records,
                                                "\x57\x5b\xd9\xfc\x06\0\0\0\0\0\0\0\x02"
                                                "step 7"s}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(RecordFormats, WriteTheBytesTheyAlwaysWrote) {
  EXPECT_EQ(format.framed("step 7", kind), GetParam().bytes);
}

TEST_P(RecordFormats, ReadARecordAndSayWhereTheNextOneBegins) {
  const std::string bytes = GetParam().bytes + "what follows";
  const auto record = format.first_of(bytes, UINT64_MAX);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->payload, "step 7");
  EXPECT_EQ(record->kind, kind);
  EXPECT_EQ(record->size, static_cast<std::int64_t>(GetParam().bytes.size()));
}

TEST_P(RecordFormats, RefuseARecordWhereverItIsCutOrFlipped) {
  const std::string& whole = GetParam().bytes;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    EXPECT_FALSE(format.first_of(whole.substr(0, at), UINT64_MAX)) << "cut to " << at;
    std::string bytes = whole + std::string(64, '\0');
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    EXPECT_FALSE(format.first_of(bytes, UINT64_MAX)) << "byte " << at;
  }
}

TEST_P(RecordFormats, RefuseZerosAndWhatIsTooLong) {
  EXPECT_FALSE(format.first_of(std::string(64, '\0'), UINT64_MAX));
  EXPECT_FALSE(format.first_of(format.framed("", kind), UINT64_MAX));
  EXPECT_FALSE(format.first_of(GetParam().bytes, 5));
  EXPECT_TRUE(format.first_of(GetParam().bytes, 6));
}

TEST_P(RecordFormats, ReadAFileRecordByRecord) {
  const TemporaryFolder folder;
  const std::string large(1 << 20, 'x');  // longer than a window reads at once
  write_file(folder / "f", "head" + GetParam().bytes + format.framed(large, kind) + "tail");
  const File file(folder / "f", O_RDONLY);
  FileWindow window(file);
  const auto first = format.at(window, 4);

  ASSERT_TRUE(first);
  EXPECT_EQ(first->payload, "step 7");

  const std::int64_t behind = 4 + first->size;
  const auto second = format.at(window, behind);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->payload, large);

  const std::int64_t end = behind + second->size;
  EXPECT_FALSE(format.at(window, end));
  EXPECT_FALSE(format.at(window, end + 4));
  EXPECT_FALSE(format.at(window, end + 400));
}

}  // namespace
}  // namespace dccast::storage
