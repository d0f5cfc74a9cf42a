#include "server/access/token_uses.hpp"

#include <gtest/gtest.h>

namespace dccast::access {
namespace {

TEST(TokenUses, TheLastUseIsKept) {
  TokenUses uses;
  EXPECT_FALSE(uses.last("a"));
  uses.note("a", {1, "ipv4:192.0.2.1:40000"});
  uses.note("a", {2, "ipv4:192.0.2.7:40000"});
  EXPECT_EQ(uses.last("a")->unix_s, 2);
  EXPECT_EQ(uses.last("a")->address, "ipv4:192.0.2.7:40000");
}

TEST(TokenUses, TheOldestGivesWay) {
  TokenUses uses;
  for (std::size_t i = 0; i < TokenUses::most_kept; ++i)
    uses.note(std::to_string(i), {static_cast<std::int64_t>(i), ""});
  uses.note("0", {20000, ""});
  uses.note("new", {20001, ""});
  EXPECT_TRUE(uses.last("0"));
  EXPECT_FALSE(uses.last("1"));
  EXPECT_TRUE(uses.last("new"));
}

}  // namespace
}  // namespace dccast::access
