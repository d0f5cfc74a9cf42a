#include "client/session/mqtt.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/session/failure.hpp"

namespace dccast::client {
namespace {

using ::testing::HasSubstr;

TEST(Mqtt, ATopicHasAHostAPortAndAName) {
  const Topic plain = parse_topic("mqtt://broker.plant/pit 3/readings");
  EXPECT_EQ(plain.host, "broker.plant");
  EXPECT_EQ(plain.port, 1883);
  EXPECT_EQ(plain.name, "pit 3/readings");
  EXPECT_FALSE(plain.over_tls);

  const Topic secure = parse_topic("mqtts://[::1]:9000/+/x");
  EXPECT_EQ(secure.host, "::1");
  EXPECT_EQ(secure.port, 9000);
  EXPECT_EQ(secure.name, "+/x");
  EXPECT_TRUE(secure.over_tls);
  EXPECT_EQ(parse_topic("mqtts://b/x").port, 8883);

  EXPECT_TRUE(is_topic("mqtt://b/x"));
  EXPECT_FALSE(is_topic("mqtt.csv"));
}

void expect_address_refused(const std::string& text, const std::string& why) {
  try {
    parse_topic(text);
    FAIL() << text;
  } catch (const CommandFailed& failure) {
    EXPECT_EQ(failure.code(), ExitCode::invalid);
    EXPECT_THAT(failure.what(), HasSubstr(why));
    EXPECT_THAT(failure.what(), HasSubstr("permitted: mqtt://HOST[:PORT]/TOPIC"));
  }
}

TEST(Mqtt, AnAddressThatNamesNoTopicIsRefused) {
  expect_address_refused("mqtt://broker", "the topic is missing");
  expect_address_refused("mqtt://broker/", "the topic is missing");
  expect_address_refused("mqtt:///pit3", "the host is missing");
  expect_address_refused("mqtt://broker:0/pit3", "the port is not between 1 and 65535");
  expect_address_refused("mqtt://broker:1883x/pit3", "the port is not between");
  expect_address_refused("mqtt://anna:secret@broker/pit3", "belong into the file of --broker");
  expect_address_refused("tcp://broker/pit3", "is no address of a topic");
}

}  // namespace
}  // namespace dccast::client
