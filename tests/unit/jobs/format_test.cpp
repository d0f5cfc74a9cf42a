#include "server/jobs/folder/format.hpp"

#include <gtest/gtest.h>

#include "core/storage/file.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

TEST(DataFormat, StandsTwiceInTheHeader) {
  const std::string header = file_header("DCCASTJD");
  EXPECT_EQ(header, std::string("DCCASTJD\4\0\0\0\4\0\0\0", 16));
  EXPECT_NO_THROW(require_data_format("folder", header, "DCCASTJD"));
}

TEST(DataFormat, AnotherOneIsRefusedWithFolderFormatsAndRemedy) {
  // Formats of which one number is zero, as before it stood twice, and of a later version.
  for (const auto& [format, again] : {std::pair{2, 0}, {1, 0}, {9, 9}}) {
    std::string header = file_header("DCCASTJD");
    header[8] = static_cast<char>(format);
    header[12] = static_cast<char>(again);
    try {
      require_data_format("/data/jobs/7", header, "DCCASTJD");
      FAIL() << format;
    } catch (const OtherFormat& error) {
      const std::string text = error.what();
      const std::string found = "format " + std::to_string(format);
      for (const std::string& part :
           {std::string("/data/jobs/7"), found, std::string("reads format 4"),
            std::string("move it away"), std::string("another data_directory")})
        EXPECT_NE(text.find(part), std::string::npos) << text;
    }
  }
}

TEST(DataFormat, ADamagedHeaderIsNoOtherFormat) {
  const std::string header = file_header("DCCASTJD");
  for (std::size_t byte = 0; byte < header.size(); ++byte) {
    std::string damaged = header;
    damaged[byte] = static_cast<char>(damaged[byte] ^ 4);
    EXPECT_NO_THROW(require_data_format("folder", damaged, "DCCASTJD")) << byte;
  }
  EXPECT_NO_THROW(require_data_format("folder", header.substr(0, 12), "DCCASTJD"));
}

TEST(DataFormat, ADescriptionOfAnotherOneIsRefused) {
  const TemporaryFolder folder;
  write_job_description(folder.path(), {});
  std::string bytes = storage::read_file(folder / description_file);
  bytes[8] = bytes[12] = 2;
  storage::write_file(folder / description_file, bytes);
  EXPECT_THROW(read_job_description(folder.path()), OtherFormat);
}

}  // namespace
}  // namespace dccast::jobs
