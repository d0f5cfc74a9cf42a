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

/// Whether a socket in this folder gets another path, of the same file.
void expect_replaced(const fs::path& folder) {
  fs::create_directories(folder);
  std::ofstream(folder / "worker.sock") << "here";
  const SocketPath socket("unix:" + (folder / "worker.sock").string());
  EXPECT_TRUE(socket.path().string().starts_with("/proc/self/fd/")) << socket.path();
  EXPECT_LT(socket.path().string().size(), sizeof(sockaddr_un::sun_path));
  EXPECT_TRUE(fs::equivalent(socket.path(), folder / "worker.sock"));
}

TEST(SocketPath, ShortensALongOneToTheSameFile) {
  const TemporaryFolder parent;
  expect_replaced(parent.path() / std::string(100, 'd') / std::string(100, 'd'));
}

// gRPC took "%41" for "A", and the worker found no daemon.
TEST(SocketPath, KeepsSpecialCharactersFromBeingReadAsAnAddress) {
  const TemporaryFolder parent;
  for (const char* name : {"da ta", "50%41", "what?", "#1", "dir=1,b", "Gießerei"})
    expect_replaced(parent.path() / name);
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
