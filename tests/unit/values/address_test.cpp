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

TEST(Address, HasAPortInRange) {
  EXPECT_EQ(port_of("casthouse:7118"), 7118);
  EXPECT_EQ(port_of("[::1]:0"), 0);
  for (const char* address : {"casthouse", "casthouse:", ":65536", ":-1", ":7x", "[::1]"})
    EXPECT_FALSE(port_of(address)) << address;
}

TEST(Address, OfAWebServerIsAnOrigin) {
  for (const char* address :
       {"https://dccast.plant.example", "https://casthouse:8443", "https://[2001:db8::7]:443",
        "https://[2001:db8::7]", "https://192.0.2.7"})
    EXPECT_TRUE(is_web_origin(address)) << address;
  for (const char* address :
       {"", "https://", "https://:443", "http://casthouse", "https://casthouse/", "casthouse",
        "https://a/path", "https://a:b", "https://a:65536", "https://a:", "https://anna@casthouse",
        "https://a b", "https://a#b", "https://[2001:db8::7", "https://casthouse?x"})
    EXPECT_FALSE(is_web_origin(address)) << address;
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
