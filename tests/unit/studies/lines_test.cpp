#include "server/studies/lines.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "core/storage/file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::studies {
namespace {

v1::LineCasting casting(const std::string& job) {
  v1::LineCasting made;
  made.set_job(job);
  made.mutable_following()->set_ensemble("study");
  return made;
}

std::vector<v1::ObservedCurl> curls() {
  v1::ObservedCurl curl;
  curl.set_monitor("corner");
  curl.add_time_s(30.0);
  curl.add_curl_m(0.01);
  curl.add_deviation_m(5e-4);
  return {curl};
}

TEST(Lines, KeepWhatCastingsTellForTheNextDaemon) {
  const TemporaryFolder folder;
  {
    Lines lines(folder / "lines");
    EXPECT_TRUE(lines.list().lines().empty());
    EXPECT_EQ(lines.begin("pit-3", "anna").owner(), "anna");
    EXPECT_EQ(lines.begin("pit-3", "bert").owner(), "anna") << "it is there already";
    lines.add("pit-3", casting("job-1"));
    lines.add("pit-3", casting("job-2"));
    lines.add("pit-3", casting("job-1"));  // repeated after a lost answer
    lines.end_casting("pit-3", "job-1", curls());
    lines.end_casting("pit-3", "job-1", {});
  }

  Lines lines(folder / "lines");
  const v1::Line line = lines.find("pit-3").value();
  ASSERT_EQ(line.castings_size(), 2);
  EXPECT_TRUE(line.castings(0).ended());
  EXPECT_EQ(line.castings(0).curls(0).curl_m(0), 0.01) << "told once";
  EXPECT_FALSE(line.castings(1).ended());
  EXPECT_EQ(lines.list().lines_size(), 1);
}

TEST(Lines, BeginAfreshOrAreRemoved) {
  const TemporaryFolder folder;
  Lines lines(folder / "lines");
  EXPECT_FALSE(lines.restart("pit-3"));
  EXPECT_FALSE(lines.remove("pit-3"));

  lines.begin("pit-3", "anna");
  lines.add("pit-3", casting("job-1"));
  const v1::Line afresh = lines.restart("pit-3").value();
  EXPECT_TRUE(afresh.castings().empty());
  EXPECT_TRUE(afresh.has_restart_time());
  EXPECT_EQ(afresh.owner(), "anna");

  // A casting of before tells the line nothing any more.
  lines.end_casting("pit-3", "job-1", curls());
  EXPECT_TRUE(lines.find("pit-3")->castings().empty());
  EXPECT_TRUE(lines.remove("pit-3"));
  lines.add("pit-3", casting("job-3"));
  EXPECT_FALSE(lines.find("pit-3"));
}

TEST(Lines, NamesArePermittedThatStayInTheFolder) {
  for (const char* name : {"pit-3", "A", "2", "line_4.b"}) EXPECT_TRUE(is_line_name(name)) << name;
  for (const std::string& name :
       {std::string(), std::string("../x"), std::string(".x"), std::string("a b"),
        std::string("a/b"), std::string("\xC3\xA4"), std::string(65, 'a')})
    EXPECT_FALSE(is_line_name(name)) << name;

  const TemporaryFolder folder;
  Lines lines(folder / "lines");
  storage::write_file(folder / "x.bin", "DCCASTLN");
  EXPECT_FALSE(lines.find("../x"));
  EXPECT_FALSE(lines.remove("../x"));
}

TEST(Lines, ADamagedFileIsNamed) {
  const TemporaryFolder folder;
  Lines lines(folder / "lines");
  lines.begin("pit-3", "anna");
  const auto path = folder.path() / "lines" / "pit-3.bin";
  std::string bytes = storage::read_file(path);
  bytes.back() ^= 1;
  storage::write_file(path, bytes);
  try {
    lines.find("pit-3");
    FAIL();
  } catch (const DamagedLine& damaged) {
    EXPECT_THAT(damaged.what(), ::testing::HasSubstr("pit-3.bin, is damaged"));
  }
  EXPECT_TRUE(lines.remove("pit-3"));
}

TEST(Lines, WhatIsNoFileIsNamedBesideTheOthers) {
  const TemporaryFolder folder;
  Lines lines(folder.path());
  lines.begin("pit-3", "anna");
  ASSERT_EQ(::mkfifo((folder.path() / "pit-4.bin").c_str(), 0600), 0);
  const v1::ListLinesResponse listed = lines.list();
  ASSERT_EQ(listed.lines_size(), 1);
  EXPECT_EQ(listed.lines(0).name(), "pit-3");
  ASSERT_EQ(listed.damaged_size(), 1);
  EXPECT_EQ(listed.damaged(0), "pit-4");
}

}  // namespace
}  // namespace dccast::studies
