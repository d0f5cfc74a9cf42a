#include "server/studies/surface_keeper.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <stdexcept>

namespace dccast::studies {
namespace {

/// Studies that get no more runs after some looks.
struct Looks {
  std::mutex mutex;
  std::condition_variable changed;
  std::map<std::string, int> of;

  bool look(const std::string& study, int most) {
    const std::lock_guard lock(mutex);
    changed.notify_all();
    return ++of[study] < most;
  }
  bool until(const std::string& study, int count) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::seconds(30), [&] { return of[study] >= count; });
  }
};

TEST(SurfaceKeeper, LooksUntilAStudyGetsNoMoreRuns) {
  Looks looks;
  SurfaceKeeper keeper([&](const std::string& study) { return looks.look(study, 2); });
  keeper.follow("a");
  ASSERT_TRUE(looks.until("a", 2));
  keeper.follow("b");
  ASSERT_TRUE(looks.until("b", 2));
  keeper.stop();
  EXPECT_EQ(looks.of["a"], 2);
}

TEST(SurfaceKeeper, WhatCannotBeBuiltEndsNothing) {
  Looks looks;
  SurfaceKeeper keeper([&](const std::string& study) -> bool {
    looks.look(study, 1);
    throw std::runtime_error("the disk is gone");
  });
  keeper.follow("a");
  ASSERT_TRUE(looks.until("a", 1));
  keeper.follow("b");
  EXPECT_TRUE(looks.until("b", 1));
}

TEST(SurfaceKeeper, EndsWithoutAStudy) {
  SurfaceKeeper keeper([](const std::string&) { return true; });
  keeper.stop();
  keeper.follow("a");
}

}  // namespace
}  // namespace dccast::studies
