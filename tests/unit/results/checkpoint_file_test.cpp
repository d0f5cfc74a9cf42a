#include "core/results/checkpoint_file.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "core/storage/file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::results {
namespace {

Sections sample_sections() {
  Sections content;
  content.set("empty", Sections::Reals{});
  content.set("displacement", Sections::Reals{1.0 / 3.0, -0.0, 5e-324, 1e308});
  content.set("contact", Sections::Integers{0, -1, std::numeric_limits<std::int64_t>::max()});
  content.set("hash", std::string("a\0b", 3));
  return content;
}

using storage::read_file;

/// Overwrites the file with `bytes`, without the care of the code under test.
void damage(const std::filesystem::path& path, const std::string& bytes) {
  storage::write_file(path, bytes);
}

TEST(Sections, AreTypedByName) {
  const Sections content = sample_sections();
  EXPECT_EQ(content.integers("contact").size(), 3u);
  EXPECT_THROW(content.reals("contact"), std::out_of_range);
  EXPECT_THROW(content.text("nowhere"), std::out_of_range);
}

TEST(Checkpoint, KeepsEveryBit) {
  const TemporaryFolder folder;
  Sections content = sample_sections();
  const double odd_nan = std::bit_cast<double>(std::uint64_t{0x7ff80000deadbeef});
  content.set_real("nan", odd_nan);
  write_checkpoint(folder / "c", content);
  const CheckpointRead read = read_checkpoint(folder / "c");
  ASSERT_TRUE(read.content) << read.reason;
  EXPECT_EQ(encode(*read.content), encode(content));
  EXPECT_TRUE(std::signbit(read.content->reals("displacement")[1]));
  EXPECT_EQ(std::bit_cast<std::uint64_t>(read.content->real("nan")),
            std::bit_cast<std::uint64_t>(odd_nan));
}

TEST(Checkpoint, ReplacesTheOneBeforeAndLeavesNoTemporary) {
  const TemporaryFolder folder;
  write_checkpoint(folder / "c", {});
  write_checkpoint(folder / "c", sample_sections());
  EXPECT_EQ(read_checkpoint(folder / "c").content->all().size(), 4u);
  EXPECT_FALSE(std::filesystem::exists(folder / "c.tmp"));
}

TEST(Checkpoint, SaysThatItIsMissing) {
  const TemporaryFolder folder;
  EXPECT_EQ(read_checkpoint(folder / "c").reason, "missing");
}

TEST(Checkpoint, IsRefusedWhereverItIsCut) {
  const TemporaryFolder folder;
  write_checkpoint(folder / "c", sample_sections());
  const std::string whole = read_file(folder / "c");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    damage(folder / "c", whole.substr(0, size));
    const CheckpointRead read = read_checkpoint(folder / "c");
    EXPECT_FALSE(read.content);
    EXPECT_EQ(read.reason, "truncated") << "cut to " << size;
  }
}

TEST(Checkpoint, IsRefusedWhicheverByteFlips) {
  const TemporaryFolder folder;
  write_checkpoint(folder / "c", sample_sections());
  const std::string whole = read_file(folder / "c");
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ 0x10);
    damage(folder / "c", bytes);
    EXPECT_FALSE(read_checkpoint(folder / "c").content) << "byte " << i;
  }
}

TEST(Checkpoint, NamesTheReason) {
  const TemporaryFolder folder;
  write_checkpoint(folder / "c", sample_sections());
  const std::string whole = read_file(folder / "c");
  const auto reason_with = [&](std::size_t byte) {
    std::string bytes = whole;
    bytes[byte] = static_cast<char>(bytes[byte] + 1);
    damage(folder / "c", bytes);
    return read_checkpoint(folder / "c").reason;
  };
  EXPECT_EQ(reason_with(0), "not a checkpoint");
  EXPECT_EQ(reason_with(8), "checkpoint format 2; this program reads format 1");
  EXPECT_EQ(reason_with(whole.size() - 1), "checksum");
}

}  // namespace
}  // namespace dccast::results
