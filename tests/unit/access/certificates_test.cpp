#include "server/access/certificates.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>

#include "core/storage/file.hpp"
#include "server/access/machine_names.hpp"
#include "server/access/users.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::access {
namespace {

Certificate read(const std::filesystem::path& file) {
  return read_certificate(storage::read_file(file), file.string());
}

TEST(Pki, IssuesACertificateForEachName) {
  const TemporaryFolder folder;
  const Pki pki(folder.path());
  EXPECT_FALSE(pki.exists());

  pki.init();
  EXPECT_TRUE(pki.exists());

  pki.issue_server({"casthouse", "10.1.2.3", "::1"}, 90);
  const Certificate server = read(pki.server());
  EXPECT_EQ(server.name, "casthouse");
  EXPECT_EQ(server.names, (std::vector<std::string>{"casthouse", "10.1.2.3", "::1"}));
  EXPECT_NEAR(static_cast<double>(server.ends_unix - ::time(nullptr)), 90 * 86400.0, 10.0);
  EXPECT_LT(server.begins_unix, ::time(nullptr));
  EXPECT_EQ(server.sha256.size(), 64u);
  EXPECT_NE(server.sha256, read(pki.ca()).sha256);
}

TEST(Pki, FilesAreTheOwnersAlone) {
  const TemporaryFolder folder;
  const Pki pki(folder.path());
  pki.init();
  pki.issue_server({"casthouse"}, 90);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path())) {
    struct stat status;
    ASSERT_EQ(::stat(entry.path().c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0077, 0u) << entry.path();
  }
}

TEST(Pki, TheCaIsNotReplacedAndOutlivesARenewal) {
  const TemporaryFolder folder;
  const Pki pki(folder.path());
  pki.init();
  const std::string before = read(pki.ca()).sha256;
  EXPECT_THROW(pki.init(), Refused);
  pki.issue_server({"casthouse"}, 90);
  const std::string first = read(pki.server()).sha256;
  pki.issue_server({"casthouse"}, 90);
  EXPECT_NE(read(pki.server()).sha256, first);
  EXPECT_EQ(read(pki.ca()).sha256, before);
}

TEST(Pki, ACertificateOfAUserNamesIt) {
  const TemporaryFolder folder;
  const Pki pki(folder.path());
  pki.init();
  pki.issue_user("anna", 365, folder.path());
  EXPECT_EQ(read(folder / "anna.pem").name, "anna");
}

TEST(Pki, NamesThatAreNoneAreRefused) {
  const TemporaryFolder folder;
  const Pki pki(folder.path());
  pki.init();
  EXPECT_THROW(pki.issue_server({}, 90), Refused);
  EXPECT_THROW(pki.issue_server({"a,DNS:b"}, 90), Refused);
  EXPECT_THROW(read_certificate("no PEM", "x.pem"), Refused);
}

TEST(Pki, ThisMachineHasANameAndLoopback) {
  const auto names = host_names();
  EXPECT_NE(std::find(names.begin(), names.end(), "127.0.0.1"), names.end());
  EXPECT_NE(std::find(names.begin(), names.end(), "localhost"), names.end());
}

}  // namespace
}  // namespace dccast::access
