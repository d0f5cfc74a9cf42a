#include "core/base/team.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <numeric>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace dccast {
namespace {

TEST(Team, AThreadWithoutOneIsAlone) {
  EXPECT_EQ(team_members(), 1);
  int calls = 0;
  together([&](int member, int members) {
    EXPECT_EQ(member, 0);
    EXPECT_EQ(members, 1);
    ++calls;
  });
  EXPECT_EQ(calls, 1);
}

TEST(Team, IsLentForAScope) {
  Team team(3), other(2);
  const Team::Lent lent(&team);
  EXPECT_EQ(team_members(), 3);
  {
    const Team::Lent another(&other);
    EXPECT_EQ(team_members(), 2);
    const Team::Lent none(nullptr);
    EXPECT_EQ(team_members(), 1);
  }
  EXPECT_EQ(team_members(), 3);
  std::thread([] { EXPECT_EQ(team_members(), 1); }).join();
}

TEST(Team, EveryMemberThatIsThereDoesItsShareOnce) {
  Team team(3);
  const Team::Lent lent(&team);
  for (int call = 0; call < 1000; ++call) {
    std::atomic<int> calls{0}, sum{0}, all{0};
    together([&](int member, int members) {
      ++calls;
      sum += member;
      all = members;
    });
    ASSERT_EQ(calls, all);
    ASSERT_EQ(sum, all * (all - 1) / 2);
  }
}

TEST(Team, EveryPartIsDoneOnce) {
  Team team(2);
  const Team::Lent lent(&team);
  std::vector<int> done(64, 0);
  for (std::size_t parts = 0; parts < done.size(); ++parts) {
    std::fill(done.begin(), done.end(), 0);
    for_each_part(parts, [&](std::size_t part) { ++done[part]; });
    ASSERT_EQ(std::accumulate(done.begin(), done.end(), 0), int(parts));
    for (std::size_t part = 0; part < parts; ++part) ASSERT_EQ(done[part], 1);
  }
}

TEST(Team, StretchesCoverAllNumbersOnce) {
  Team team(2);
  const Team::Lent lent(&team);
  for (const std::size_t count : {0u, 1u, 99u, 100u, 1234u, 5000u}) {
    std::vector<int> met(count, 0);
    for_each_stretch(count, 100, [&](std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) ++met[i];
    });
    EXPECT_EQ(met, std::vector<int>(count, 1));
  }
}

TEST(Team, ManyShortCallsAllEnd) {
  Team team(2);
  const Team::Lent lent(&team);
  long sum = 0;
  for (int call = 0; call < 20000; ++call) {
    std::atomic<int> parts{0};
    for_each_part(4, [&](std::size_t) { ++parts; });
    sum += parts;
  }
  EXPECT_EQ(sum, 80000);
}

TEST(Team, WakesMembersThatHaveGoneToSleep) {
  Team team(2);
  const Team::Lent lent(&team);
  for (int call = 0; call < 20; ++call) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // longer than members spin
    std::atomic<int> parts{0};
    for_each_part(4, [&](std::size_t) { ++parts; });
    ASSERT_EQ(parts, 4);
  }
}

TEST(Team, InsideItsWorkAThreadIsAlone) {
  Team team(2);
  const Team::Lent lent(&team);
  std::atomic<int> inner{0};
  for_each_part(8, [&](std::size_t) {
    EXPECT_EQ(team_members(), 1);
    for_each_part(8, [&](std::size_t) { ++inner; });
    together([&](int, int members) { EXPECT_EQ(members, 1); });
  });
  EXPECT_EQ(inner, 64);
  EXPECT_EQ(team_members(), 2);
}

TEST(Team, AnExceptionOfAnyPartComesOutAndTheTeamGoesOn) {
  Team team(2);
  const Team::Lent lent(&team);
  for (std::size_t bad = 0; bad < 16; ++bad) {
    const auto throw_at_bad = [bad](std::size_t part) {
      if (part == bad) throw std::out_of_range("this part");
    };
    EXPECT_THROW(for_each_part(16, throw_at_bad), std::out_of_range);
    EXPECT_EQ(team_members(), 2);
    std::atomic<int> parts{0};
    for_each_part(16, [&](std::size_t) { ++parts; });
    EXPECT_EQ(parts, 16);
  }
}

TEST(Team, OfSeveralExceptionsOneComesOut) {
  Team team(3);
  const Team::Lent lent(&team);
  for (int call = 0; call < 100; ++call) {
    EXPECT_THROW(together([](int, int) { throw std::runtime_error("all"); }), std::runtime_error);
  }
}

TEST(Team, MembersCanWaitForEachOther) {
  Team team(2);
  const Team::Lent lent(&team);
  constexpr int places = 2000;
  for (int call = 0; call < 20; ++call) {
    Progress progress(-1);
    std::vector<int> value(places, 0);  // of each its own, one more than the one before
    together([&](int member, int members) {
      for (int place = member; place < places; place += members) {
        progress.wait_for(place - 1);
        value[std::size_t(place)] = place == 0 ? 1 : value[std::size_t(place) - 1] + 1;
        progress.reach(place);
      }
    });
    ASSERT_EQ(value.back(), places);
  }
}

TEST(Team, CountsTheProcessorSecondsOfItsOtherMembers) {
  Team team(2);
  const Team::Lent lent(&team);
  const double before = team.processor_seconds();
  std::set<std::thread::id> who;
  for (int call = 0; call < 200 && who.size() < 2; ++call) {
    std::atomic<double> sink{0.0};
    std::vector<std::thread::id> of_part(8);
    for_each_part(of_part.size(), [&](std::size_t part) {
      of_part[part] = std::this_thread::get_id();
      double x = 1.0;
      for (int i = 0; i < 200000; ++i) x = 0.5 * x + 1.0;
      sink = x;
    });
    who.insert(of_part.begin(), of_part.end());
  }

  EXPECT_EQ(who.size(), 2u) << "the other member never came";
  EXPECT_GT(team.processor_seconds(), before);
}

TEST(Team, OfOneStartsNoThread) {
  Team team(1);
  const Team::Lent lent(&team);
  EXPECT_EQ(team_members(), 1);
  EXPECT_EQ(team.processor_seconds(), 0.0);
  const auto caller = std::this_thread::get_id();
  for_each_part(8, [&](std::size_t) { EXPECT_EQ(std::this_thread::get_id(), caller); });
}

}  // namespace
}  // namespace dccast
