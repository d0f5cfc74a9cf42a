#include "core/storage/background.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace dccast::storage {
namespace {

TEST(Background, DoesItsTasksInTheirOrder) {
  std::vector<int> done;
  Background background;
  for (int i = 0; i < 100; ++i) background.post([&done, i] { done.push_back(i); });
  background.wait();
  ASSERT_EQ(done.size(), 100u);
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
}

TEST(Background, EndsWhatWasPostedBeforeItGoes) {
  std::atomic<int> done = 0;
  {
    Background background;
    for (int i = 0; i < 3; ++i)
      background.post([&done] {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));  // so that some wait
        ++done;
      });
  }
  EXPECT_EQ(done, 3);
}

/// It was waited for without end: a worker without memory stood still instead of failing.
TEST(Background, ATaskWithoutAThreadIsNotWaitedFor) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizer ends a process without memory";
#endif
  pthread_attr_t usual, larger;  // than the stacks that are left of other threads
  ASSERT_EQ(::pthread_getattr_default_np(&usual), 0);
  ASSERT_EQ(::pthread_getattr_default_np(&larger), 0);

  ::pthread_attr_setstacksize(&larger, std::size_t{64} << 20);
  ::pthread_setattr_default_np(&larger);
  rlimit before{};
  ::getrlimit(RLIMIT_AS, &before);
  bool done = false;
  Background background;
  const rlimit none{.rlim_cur = 1, .rlim_max = before.rlim_max};
  ::setrlimit(RLIMIT_AS, &none);
  EXPECT_THROW(background.post([&done] { done = true; }), std::system_error);

  ::setrlimit(RLIMIT_AS, &before);
  ::pthread_setattr_default_np(&usual);
  background.wait();
  EXPECT_FALSE(done);

  background.post([&done] { done = true; });
  background.wait();
  EXPECT_TRUE(done);
}

TEST(Background, HoldsBackWhoIsFarAhead) {
  std::atomic<int> waiting = 0, most = 0;
  Background background;
  for (int i = 0; i < 20; ++i) {
    background.post([&waiting] {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // slower than who posts
      --waiting;
    });
    most = std::max<int>(most, ++waiting);
  }
  EXPECT_LE(most, 4);  // one being executed, two waiting, one posted before it was counted
}

TEST(Background, TellsOfAFailureOnceAndDropsWhatFollowed) {
  std::atomic<bool> followed = false;
  std::promise<void> both_posted;
  Background background;
  background.post([&both_posted] {
    both_posted.get_future().wait();
    throw std::runtime_error("the disk is full");
  });
  background.post([&followed] { followed = true; });
  both_posted.set_value();

  EXPECT_THROW(background.wait(), std::runtime_error);
  EXPECT_FALSE(followed);

  background.post([&followed] { followed = true; });
  background.wait();
  EXPECT_TRUE(followed);
}

}  // namespace
}  // namespace dccast::storage
