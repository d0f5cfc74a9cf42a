#pragma once

#include <chrono>
#include <thread>

namespace dccast {

/// Waits for what another thread or process brings about. @return false: it did not come in time
template <class Condition>
bool eventually(Condition&& condition,
                std::chrono::milliseconds longest = std::chrono::seconds(10)) {
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// For a time in which nothing may come. @return false: the condition did not hold all along
template <class Condition>
bool stays(Condition&& condition, std::chrono::milliseconds time) {
  return !eventually([&] { return !condition(); }, time);
}

}  // namespace dccast
