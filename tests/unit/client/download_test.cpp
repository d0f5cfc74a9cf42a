#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/session/download.hpp"
#include "fake_service.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {
namespace {

namespace fs = std::filesystem;

struct Fetch : testing::Test {
  FakeService service;
  fs::path folder = fs::path(testing::TempDir()) / ("dccast_fetch_" + std::to_string(::getpid()));
  fs::path file = folder / "r.h5";
  std::ostringstream messages;

  void SetUp() override {
    fs::create_directories(folder);
    for (int i = 0; i < 5000; ++i) service.artifact += std::to_string(i);
    write(folder / "whole", service.artifact);
    service.artifact_sha256 = values::sha256_of_file(folder / "whole");
  }
  void TearDown() override { fs::remove_all(folder); }

  static void write(const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  }
  Download fetch() {
    Connection connection = service.connect();
    return download(connection, "job", "results.h5", file, messages);
  }
};

TEST_F(Fetch, AppearsUnderItsNameWithTheRightSum) {
  EXPECT_EQ(fetch().bytes, static_cast<std::int64_t>(service.artifact.size()));
  EXPECT_EQ(values::sha256_of_file(file), service.artifact_sha256);
  EXPECT_FALSE(fs::exists(file.string() + ".part"));
}

TEST_F(Fetch, GoesOnAfterAPart) {
  write(file.string() + ".part", service.artifact.substr(0, 1000));
  EXPECT_EQ(fetch().resumed_at, 1000);
  EXPECT_EQ(values::sha256_of_file(file), service.artifact_sha256);
}

TEST_F(Fetch, ACutStreamIsContinued) {
  service.bytes_per_stream = service.artifact.size() / 2;
  fetch();
  EXPECT_EQ(values::sha256_of_file(file), service.artifact_sha256);
  EXPECT_GE(service.streams, 2);
}

TEST_F(Fetch, APartOfAnotherFileIsThrownAway) {
  write(file.string() + ".part", "something else");
  EXPECT_EQ(fetch().resumed_at, 0);
  EXPECT_EQ(values::sha256_of_file(file), service.artifact_sha256);
  write(file.string() + ".part", service.artifact + "longer");
  fetch();
  EXPECT_EQ(values::sha256_of_file(file), service.artifact_sha256);
}

TEST_F(Fetch, AWrongSumNeverBecomesAResult) {
  service.artifact_sha256 = std::string(64, '0');
  EXPECT_THROW(fetch(), CommandFailed);
  EXPECT_FALSE(fs::exists(file));
}

}  // namespace
}  // namespace dccast::client
