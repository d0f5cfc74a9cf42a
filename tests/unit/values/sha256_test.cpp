#include "proto/values/digests.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <system_error>

namespace dccast::values {
namespace {

// FIPS 180-4 example.
TEST(Sha256, MatchesThePublishedExample) {
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Sha256, OfAFileIsThatOfItsContent) {
  const auto file =
      std::filesystem::temp_directory_path() / ("dccast-sha256-" + std::to_string(::getpid()));
  const std::string content(1000003, 'q');
  std::ofstream(file) << content;
  EXPECT_EQ(sha256_of_file(file), sha256(content));
  std::filesystem::remove(file);
  EXPECT_THROW(sha256_of_file(file), std::system_error);
}

}  // namespace
}  // namespace dccast::values
