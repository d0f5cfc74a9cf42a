#include "server/jobs/socket_path.hpp"

#include <gtest/gtest.h>
#include <sys/un.h>

#include <fstream>

#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

namespace fs = std::filesystem;

TEST(SocketPath, LeavesWhatTheSystemTakes) {
  EXPECT_EQ(SocketPath("unix:/run/dccast/worker.sock").address(), "unix:/run/dccast/worker.sock");
  EXPECT_EQ(SocketPath("127.0.0.1:7117").address(), "127.0.0.1:7117");
  EXPECT_EQ(SocketPath("127.0.0.1:7117").path(), "");
}

TEST(SocketPath, ShortensALongOneToTheSameFile) {
  const TemporaryFolder parent;
  const fs::path folder = parent.path() / std::string(100, 'd') / std::string(100, 'd');
  fs::create_directories(folder);
  std::ofstream(folder / "worker.sock") << "here";
  const SocketPath socket("unix:" + (folder / "worker.sock").string());
  EXPECT_LT(socket.path().string().size(), sizeof(sockaddr_un::sun_path));
  EXPECT_TRUE(fs::equivalent(socket.path(), folder / "worker.sock"));
}

TEST(SocketPath, SaysWhichFolderIsNotThere) {
  const std::string folder = "/nowhere/" + std::string(120, 'd');
  try {
    SocketPath("unix:" + folder + "/worker.sock");
    FAIL();
  } catch (const std::system_error& error) {
    EXPECT_NE(std::string(error.what()).find(folder), std::string::npos);
  }
}

}  // namespace
}  // namespace dccast::jobs
