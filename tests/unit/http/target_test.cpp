#include "proto/http/target.hpp"

#include <gtest/gtest.h>

namespace dccast::http {
namespace {

using Query = std::multimap<std::string, std::string>;

TEST(Target, PathAndQueryAreTakenApart) {
  const Target target = parse_target("/compare/?job=1&job=2&flag&=3&&end=");
  EXPECT_EQ(target.path, "/compare/");
  EXPECT_EQ(target.query,
            (Query{{"job", "1"}, {"job", "2"}, {"flag", ""}, {"", "3"}, {"end", ""}}));
  EXPECT_EQ(parse_target("/").path, "/");
  EXPECT_EQ(parse_target("?a=b").path, "");
  EXPECT_EQ(parse_target("/x?").query, Query());
}

TEST(Target, QueriesAreDecodedAndPathsAreNot) {
  const Target target = parse_target("/a%2Fb?set=time.end%3D20+s&k=1%2B1");
  EXPECT_EQ(target.path, "/a%2Fb");
  EXPECT_EQ(target.query, (Query{{"set", "time.end=20 s"}, {"k", "1+1"}}));
}

TEST(Target, APercentSignWithoutTwoDigitsStaysAsItIs) {
  EXPECT_EQ(decoded("%41%7a+%"), "Az+%");
  EXPECT_EQ(decoded("%4"), "%4");
  EXPECT_EQ(decoded("%4g%-1%+1"), "%4g%-1%+1");
  EXPECT_EQ(decoded("%%41"), "%A");
  EXPECT_EQ(decoded(""), "");
}

}  // namespace
}  // namespace dccast::http
