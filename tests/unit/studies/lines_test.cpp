#include "server/studies/lines.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "core/storage/file.hpp"
#include "proto/refusal/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::studies {
namespace {

v1::LineCasting casting(const std::string& job) {
  v1::LineCasting made;
  made.set_id(job);
  made.set_job(job);
  made.mutable_following()->set_ensemble("study");
  return made;
}

void cast(Lines& lines, const std::string& job, const std::string& owner = "anna",
          const std::string& line = "pit-3") {
  lines.reserve(line, owner).add(casting(job));
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
    cast(lines, "job-1");
    cast(lines, "job-2");
    cast(lines, "job-1");  // repeated after a lost answer
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

/// A daemon that was killed between the job and its line left the casting out for good.
TEST(Lines, TakeACastingThatACrashKeptFromThem) {
  const TemporaryFolder folder;
  Lines lines(folder / "lines");
  v1::LineCasting lost = casting("job-1");
  lost.mutable_begin_time()->set_seconds(1'700'000'000);
  lines.add_lost("pit-3", "anna", lost);
  lines.add_lost("pit-3", "anna", lost);
  EXPECT_EQ(lines.find("pit-3")->castings_size(), 1);
  EXPECT_EQ(lines.owner("pit-3"), "anna");

  lines.restart("pit-3");
  lines.add_lost("pit-3", "anna", lost);
  EXPECT_EQ(lines.find("pit-3")->castings_size(), 0) << "it was taken off since";
}

TEST(Lines, BeginAfreshOrAreRemoved) {
  const TemporaryFolder folder;
  Lines lines(folder / "lines");
  EXPECT_FALSE(lines.restart("pit-3"));
  EXPECT_FALSE(lines.remove("pit-3"));

  cast(lines, "job-1");
  const v1::Line afresh = lines.restart("pit-3").value();
  EXPECT_TRUE(afresh.castings().empty());
  EXPECT_TRUE(afresh.has_restart_time());
  EXPECT_EQ(afresh.owner(), "anna");

  // A casting of before tells the line nothing any more.
  lines.end_casting("pit-3", "job-1", curls());
  EXPECT_TRUE(lines.find("pit-3")->castings().empty());
  EXPECT_TRUE(lines.remove("pit-3"));
  EXPECT_FALSE(lines.find("pit-3"));
  EXPECT_FALSE(lines.owner("pit-3"));
}

TEST(Lines, ANameIsReservedUntilACastingStandsOnIt) {
  const TemporaryFolder folder;
  Lines lines(folder.path());
  {
    const auto first = lines.reserve("pit-3", "anna");
    const auto second = lines.reserve("pit-3", "bert");
    EXPECT_EQ(lines.owner("pit-3"), "anna") << "who came first";
    EXPECT_FALSE(lines.find("pit-3"));
  }
  EXPECT_FALSE(lines.owner("pit-3")) << "neither was submitted";
  cast(lines, "job-1", "bert");
  EXPECT_EQ(lines.owner("pit-3"), "bert");
  EXPECT_EQ(Lines(folder.path()).owner("pit-3"), "bert");
}

TEST(Lines, AUserHasABoundedNumberOfThem) {
  const TemporaryFolder folder;
  Lines lines(folder.path());
  for (int i = 0; i < most_lines_of_user; ++i)
    lines.reserve("pit-" + std::to_string(i), "anna").add(casting("job"));
  EXPECT_THROW(lines.reserve("one-more", "anna"), refusal::LimitReached);
  cast(lines, "job-2", "anna", "pit-1");
  cast(lines, "job-3", "bert", "one-more");
  EXPECT_EQ(lines.owner("one-more"), "bert");
}

v1::LineCasting typed(v1::LineCasting::Outcome outcome, std::int64_t count = 1) {
  v1::LineCasting made;
  made.set_outcome(outcome);
  made.set_count(count);
  made.set_ended(true);
  return made;
}

AddedCastings type(Lines& lines, std::vector<v1::LineCasting> castings, const std::string& id,
                   const std::string& request = "a") {
  return lines.reserve("pit-3", "anna").add_typed(std::move(castings), id, request);
}

/// However large castings are, the answer about a line stays small.
TEST(Lines, TheNewestCastingsAreKept) {
  const TemporaryFolder folder;
  Lines lines(folder.path());
  std::vector<v1::LineCasting> large(300, typed(v1::LineCasting::SOUND));
  for (v1::LineCasting& casting : large) casting.set_title(std::string(60'000, 'x'));
  type(lines, large, "large");
  const v1::Line kept = lines.find("pit-3").value();
  EXPECT_LE(kept.ByteSizeLong(), most_casting_bytes);
  EXPECT_GT(kept.castings_size(), 100);
  EXPECT_EQ(kept.castings().rbegin()->id(), "300");
}

TEST(Lines, TypedCastingsStandBesideFollowedOnes) {
  const TemporaryFolder folder;
  {
    Lines lines(folder / "lines");
    cast(lines, "job-1");
    EXPECT_EQ(
        type(lines, {typed(v1::LineCasting::SOUND, 200), typed(v1::LineCasting::BLED_OUT)}, "first")
            .ids,
        (std::vector<std::string>{"1", "2"}));
  }
  Lines lines(folder / "lines");
  const v1::Line line = lines.find("pit-3").value();
  ASSERT_EQ(line.castings_size(), 3);
  EXPECT_EQ(line.castings(1).outcome(), v1::LineCasting::SOUND);
  EXPECT_EQ(line.number(), 202) << "castings, not records";
  EXPECT_EQ(lines.list().lines(0).number(), 202);
  EXPECT_TRUE(lines.list().lines(0).castings().empty());
}

TEST(Lines, ARequestAddsOnce) {
  const TemporaryFolder folder;
  Lines lines(folder.path());
  const auto first = type(lines, {typed(v1::LineCasting::SOUND)}, "same");
  const auto again = Lines(folder.path())
                         .reserve("pit-3", "anna")
                         .add_typed({typed(v1::LineCasting::SOUND)}, "same", "a");
  EXPECT_EQ(again.ids, first.ids);
  EXPECT_TRUE(again.repeated);
  EXPECT_FALSE(again.other_request);
  EXPECT_TRUE(type(lines, {typed(v1::LineCasting::CRACKED)}, "same", "b").other_request);
  EXPECT_EQ(lines.find("pit-3")->castings_size(), 1);
}

TEST(Lines, SingleCastingsAreEditedAndForgotten) {
  const TemporaryFolder folder;
  Lines lines(folder.path());
  cast(lines, "job-1");
  lines.end_casting("pit-3", "job-1", curls());
  type(lines, {typed(v1::LineCasting::SOUND), typed(v1::LineCasting::SOUND)}, "x");

  EXPECT_EQ(lines.edit("pit-3", "job-1", typed(v1::LineCasting::BLED_OUT), "bert")->curls_size(), 1)
      << "what the gauges told stays";
  EXPECT_FALSE(lines.edit("pit-3", "7", typed(v1::LineCasting::SOUND), "bert"));
  EXPECT_EQ(lines.forget("pit-3", {"1", "7"}), "7");
  EXPECT_EQ(lines.find("pit-3")->castings_size(), 3) << "all or none";
  EXPECT_FALSE(lines.forget("pit-3", {"1"}));

  Lines later(folder.path());
  EXPECT_EQ(later.find("pit-3")->castings(0).outcome(), v1::LineCasting::BLED_OUT);
  EXPECT_EQ(later.find("pit-3")->castings_size(), 2);
  cast(later, "job-1");
  EXPECT_EQ(later.find("pit-3")->castings_size(), 2);
  EXPECT_EQ(type(later, {typed(v1::LineCasting::SOUND)}, "y").ids, std::vector<std::string>{"3"})
      << "a number is given once";
}

/// A daemon that is killed while it writes leaves a part of a record, which nobody was told of.
TEST(Lines, AnAppendThatWasCutShortIsDropped) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "pit-3.bin";
  Lines lines(folder.path());
  type(lines, {typed(v1::LineCasting::SOUND)}, "first");
  const std::string whole = storage::read_file(path);
  type(lines, {typed(v1::LineCasting::BLED_OUT)}, "second");
  const std::string longer = storage::read_file(path);

  for (std::size_t size = whole.size() + 1; size < longer.size(); ++size) {
    storage::write_file(path, longer.substr(0, size));
    Lines later(folder.path());
    ASSERT_EQ(later.find("pit-3")->castings_size(), 1) << size;
    type(later, {typed(v1::LineCasting::CRACKED)}, "third");
    ASSERT_EQ(Lines(folder.path()).find("pit-3")->castings(1).outcome(), v1::LineCasting::CRACKED)
        << size;
  }
  EXPECT_EQ(storage::read_file(path.string() + fmt::format(".cut-{}", whole.size())),
            longer.substr(whole.size(), longer.size() - whole.size() - 1))
      << "kept beside the file, of the last trial";

  // A record that reached the disk with another content is damage.
  std::string damaged = longer;
  damaged.back() ^= 1;
  storage::write_file(path, damaged);
  EXPECT_THROW(Lines(folder.path()).find("pit-3"), DamagedLine);
}

TEST(Lines, TenThousandCastingsAreNoBurden) {
  const TemporaryFolder folder;
  Lines lines(folder.path());
  type(lines, std::vector<v1::LineCasting>(most_castings - 1, typed(v1::LineCasting::SOUND)), "x");
  for (int i = 0; i < 3; ++i)
    type(lines, {typed(v1::LineCasting::SOUND)}, "later-" + std::to_string(i));
  const v1::Line line = lines.find("pit-3").value();
  EXPECT_EQ(line.castings_size(), most_castings);
  EXPECT_EQ(line.castings().rbegin()->id(), std::to_string(most_castings + 2));
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
  cast(lines, "job-1");
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
  cast(lines, "job-1");
  ASSERT_EQ(::mkfifo((folder.path() / "pit-4.bin").c_str(), 0600), 0);
  const v1::ListLinesResponse listed = lines.list();
  ASSERT_EQ(listed.lines_size(), 1);
  EXPECT_EQ(listed.lines(0).name(), "pit-3");
  ASSERT_EQ(listed.damaged_size(), 1);
  EXPECT_EQ(listed.damaged(0), "pit-4");
}

}  // namespace
}  // namespace dccast::studies
