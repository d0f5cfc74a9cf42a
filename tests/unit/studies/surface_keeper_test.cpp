#include "server/studies/surface_keeper.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <stdexcept>

namespace dccast::studies {
namespace {

/// Looks at studies, counted.
struct Looks {
  std::mutex mutex;
  std::condition_variable changed;
  std::map<std::string, int> of;

  void look(const std::string& study) {
    const std::lock_guard lock(mutex);
    ++of[study];
    changed.notify_all();
  }
  bool until(const std::string& study, int count) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::seconds(30), [&] { return of[study] >= count; });
  }
};

TEST(SurfaceKeeper, LooksAtAStudyOnceForEachTimeItChanges) {
  Looks looks;
  SurfaceKeeper keeper;
  keeper.start([&](const std::string& study) { looks.look(study); });
  keeper.look_at("a");
  ASSERT_TRUE(looks.until("a", 1));
  keeper.look_at("b");
  ASSERT_TRUE(looks.until("b", 1));
  keeper.look_at("b");
  ASSERT_TRUE(looks.until("b", 2));
  keeper.stop();
  EXPECT_EQ(looks.of["a"], 1);
}

TEST(SurfaceKeeper, WhatCannotBeBuiltEndsNothing) {
  Looks looks;
  SurfaceKeeper keeper;
  keeper.start([&](const std::string& study) {
    looks.look(study);
    throw std::runtime_error("the disk is gone");
  });
  keeper.look_at("a");
  ASSERT_TRUE(looks.until("a", 1));
  keeper.look_at("b");
  EXPECT_TRUE(looks.until("b", 1));
}

TEST(SurfaceKeeper, EndsWithoutAStudy) {
  SurfaceKeeper keeper;
  keeper.start([](const std::string&) {});
  keeper.stop();
  keeper.look_at("a");
}

}  // namespace
}  // namespace dccast::studies
