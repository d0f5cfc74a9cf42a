#include "server/access/audit.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <sstream>

#include "core/storage/file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::access {
namespace {

v1::AuditEvent event(const std::string& user, const std::string& job) {
  v1::AuditEvent made;
  made.set_user(user);
  made.set_call("CancelJob");
  made.set_job(job);
  made.set_outcome("OK");
  return made;
}

TEST(Audit, OneLineAnEventWhateverItHolds) {
  const TemporaryFolder folder;
  AuditLog log(folder.path());
  log.append(event("anna\n{\"user\":\"root\"}\x1b[2J", "1"));
  log.append(event(std::string(100000, 'x'), "2"));
  const std::string text = storage::read_file(folder / "audit.log");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
  EXPECT_LT(text.size(), 4096u);
  struct stat status;
  ASSERT_EQ(::stat((folder / "audit.log").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600);
}

TEST(Audit, ASecondWriterAppends) {
  const TemporaryFolder folder;
  AuditLog(folder.path()).append(event("anna", "1"));
  AuditLog(folder.path()).append(event("bert", "2"));
  std::ostringstream all;
  EXPECT_EQ(print_audit(folder.path(), {}, all), 2u);
  EXPECT_NE(all.str().find("\"user\":\"anna\""), std::string::npos) << all.str();
}

TEST(Audit, IsFilteredByUserJobAndTime) {
  const TemporaryFolder folder;
  AuditLog log(folder.path());
  log.append(event("anna", "abc"));
  log.append(event("bert", "def"));
  std::ostringstream out;
  EXPECT_EQ(print_audit(folder.path(), {.user = "anna"}, out), 1u);
  EXPECT_EQ(print_audit(folder.path(), {.job = "de"}, out), 1u);
  EXPECT_EQ(print_audit(folder.path(), {.call = "SubmitJob"}, out), 0u);
  EXPECT_EQ(print_audit(folder.path(), {.since = "2000-01-01"}, out), 2u);
  EXPECT_EQ(print_audit(folder.path(), {.since = "9999"}, out), 0u);
}

TEST(Audit, ALineCutByAFullDiskIsShown) {
  const TemporaryFolder folder;
  AuditLog(folder.path()).append(event("anna", "1"));
  storage::write_file(folder / "audit.log",
                      storage::read_file(folder / "audit.log") + "{\"time\":\"20");
  std::ostringstream out;
  EXPECT_EQ(print_audit(folder.path(), {.user = "anna"}, out), 2u);
}

}  // namespace
}  // namespace dccast::access
