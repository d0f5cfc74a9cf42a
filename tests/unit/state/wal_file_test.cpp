#include "server/state/wal_file.hpp"

#include <gtest/gtest.h>

#include "core/storage/file.hpp"
#include "tests/unit/state/state_folder_fixture.hpp"

namespace dccast::state {
namespace {

namespace fs = std::filesystem;

class WalFileTest : public StateFolderTest {
protected:
  /// A log of SQLite's own, as a killed daemon leaves it.
  WalFileTest() {
    for (int i = 0; i < 5; ++i) add_job();
    copy_ = folder_.path() / "copy-wal";
    fs::copy_file(folder_.wal(), copy_);
  }
  WalState with_flipped_bit(std::size_t byte) const {
    std::string bytes = storage::read_file(copy_);
    bytes.at(byte) = static_cast<char>(bytes[byte] ^ 16);
    const auto path = folder_.path() / "flipped-wal";
    storage::replace_file(path, bytes);
    return inspect_wal(path);
  }
  fs::path copy_;
};

TEST_F(WalFileTest, TakesWhatSqliteWritesForSound) {
  EXPECT_EQ(inspect_wal(copy_), WalState::sound);
  EXPECT_EQ(inspect_wal(folder_.path() / "none"), WalState::empty);
  fs::resize_file(copy_, 32);
  EXPECT_EQ(inspect_wal(copy_), WalState::empty);
}

TEST_F(WalFileTest, TellsAFlippedBitAnywhereInTheHeader) {
  for (std::size_t byte = 0; byte < 32; ++byte)
    EXPECT_EQ(with_flipped_bit(byte), WalState::damaged_header) << byte;
}

TEST_F(WalFileTest, TellsAFlippedBitInAFrameFromATornEnd) {
  constexpr std::size_t frame = 24 + 4096;
  const std::size_t last = fs::file_size(copy_) - frame;
  for (std::size_t offset : {0, 4, 8, 16, 24, 2000}) {
    EXPECT_EQ(with_flipped_bit(32 + frame + offset), WalState::damaged_frames) << offset;
    EXPECT_EQ(with_flipped_bit(last + offset), WalState::sound) << offset;
  }
  fs::resize_file(copy_, last + 100);
  EXPECT_EQ(inspect_wal(copy_), WalState::sound);
}

}  // namespace
}  // namespace dccast::state
