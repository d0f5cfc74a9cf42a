#include "server/jobs/digest.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/unit/jobs/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

// Check value of CRC-32C in Koopman's and other catalogues of polynomials.
TEST(Crc32c, MatchesThePublishedCheckValue) {
  EXPECT_EQ(crc32c("123456789"), 0xe3069283u);
}

// RFC 3720, appendix B.4.
TEST(Crc32c, MatchesTheExamplesOfIscsi) {
  EXPECT_EQ(crc32c(std::string(32, '\0')), 0x8a9136aau);
  EXPECT_EQ(crc32c(std::string(32, '\xff')), 0x62a8ab43u);
}

// FIPS 180-4 example.
TEST(Sha256, MatchesThePublishedExample) {
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Sha256, OfAFileIsThatOfItsContent) {
  const TemporaryFolder folder;
  const std::string content(1000003, 'q');
  std::ofstream(folder.path() / "f") << content;
  EXPECT_EQ(sha256_of_file(folder.path() / "f"), sha256(content));
  EXPECT_THROW(sha256_of_file(folder.path() / "none"), std::system_error);
}

}  // namespace
}  // namespace dccast::jobs
