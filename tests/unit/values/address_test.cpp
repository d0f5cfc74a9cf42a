#include "proto/values/address.hpp"

#include <gtest/gtest.h>

namespace dccast::values {
namespace {

TEST(Address, HasAHostAndAPort) {
  const auto parts = [](const char* address) {
    const auto [host, port] = host_and_port(address);
    return host + "|" + port;
  };
  EXPECT_EQ(parts("casthouse:7118"), "casthouse|7118");
  EXPECT_EQ(parts("casthouse"), "casthouse|");
  EXPECT_EQ(parts("[::1]:7118"), "::1|7118");
  EXPECT_EQ(parts("[::1]"), "::1|");
}

TEST(Address, OfThisMachineAloneIsLoopback) {
  for (const char* address : {"127.0.0.1:0", "127.1.2.3", "[::1]:7117", "localhost:7117"})
    EXPECT_TRUE(is_loopback(address)) << address;
  for (const char* address : {"0.0.0.0:7117", "127.example.org:7117", "localhost.example.org:7117",
                              "[::]:7117", "192.168.127.1", ""})
    EXPECT_FALSE(is_loopback(address)) << address;
}

}  // namespace
}  // namespace dccast::values
