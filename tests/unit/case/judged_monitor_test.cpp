#include <gtest/gtest.h>

#include "core/casting/case/judged_monitor.hpp"

namespace dccast::casting {
namespace {

const double none = std::nan("");

Case two_monitors(const std::string& curl) {
  Case c;
  c.monitors = {{"corner"}, {"centre"}};
  c.output.curl = curl;
  return c;
}

/// Of both monitors [m].
std::vector<std::vector<double>> curls(double corner, double centre) {
  return {{0.0, corner}, {0.0, centre}};
}

TEST(JudgedMonitor, IsTheLargestWithoutAName) {
  const Case c = two_monitors("");
  EXPECT_EQ(judged_monitor(c, curls(3e-3, none)), 0u) << "the other has none yet";
  EXPECT_EQ(judged_monitor(c, curls(3e-3, -4e-3)), 1u) << "downwards counts, too";
  EXPECT_EQ(judged_curl(c, curls(3e-3, -4e-3)), -4e-3);
  EXPECT_FALSE(judged_monitor(c, {}));
}

TEST(JudgedMonitor, IsTheOneThatTheCaseNames) {
  const Case c = two_monitors("centre");
  EXPECT_FALSE(judged_monitor(c, curls(3e-3, none)))
      << "it has no curl yet, and no other stands in for it";
  EXPECT_TRUE(std::isnan(judged_curl(c, curls(3e-3, none))));
  EXPECT_EQ(judged_monitor(c, curls(3e-3, 1e-6)), 1u);
}

}  // namespace
}  // namespace dccast::casting
