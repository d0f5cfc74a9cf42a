#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "client/session/failure.hpp"
#include "client/web/session_cookie.hpp"
#include "client/web/session_entrance.hpp"

namespace dccast::client {
namespace {

const std::string old_key(32, 'o'), new_key(32, 'n');
constexpr std::int64_t now = 1'800'000'000;
const Session session{.token = "dccast-token-12-34", .begun_unix = now, .seen_unix = now};

/// The header Cookie of a browser that was given this.
std::string sent(const std::string& set_cookie) {
  return set_cookie.substr(0, set_cookie.find(';'));
}

TEST(SessionCookie, GivesBackTheSession) {
  const SessionCookie cookie({new_key});
  const std::string set = cookie.set(session);
  EXPECT_EQ(set.find(session.token), std::string::npos);
  EXPECT_NE(set, cookie.set(session)) << "each has its own nonce";

  const auto read = cookie.read("other=1; " + sent(set), now + 60);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->token, session.token);
  EXPECT_EQ(read->begun_unix, now);
  EXPECT_EQ(read->seen_unix, now);
}

TEST(SessionCookie, RefusesEveryChangedDigit) {
  const SessionCookie cookie({new_key});
  const std::string good = sent(cookie.set(session));
  for (std::size_t i = good.find('=') + 1; i < good.size(); ++i) {
    std::string forged = good;
    forged[i] = forged[i] == '0' ? '1' : '0';
    EXPECT_FALSE(cookie.read(forged, now)) << i;
  }
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(cookie.read(good.substr(0, size), now)) << size;
}

TEST(SessionCookie, EndsAfterIdleTimeAndInAll) {
  const SessionCookie cookie({new_key});
  const std::string idle = sent(cookie.set(session));
  EXPECT_TRUE(cookie.read(idle, now + SessionCookie::idle_s - 1));
  EXPECT_FALSE(cookie.read(idle, now + SessionCookie::idle_s));

  Session used = session;
  used.seen_unix = now + SessionCookie::longest_s - 1;
  EXPECT_TRUE(cookie.read(sent(cookie.set(used)), used.seen_unix));
  EXPECT_FALSE(cookie.read(sent(cookie.set(used)), used.seen_unix + 1));
}

TEST(SessionCookie, IsSealedWithItsName) {
  const SessionCookie cookie({new_key}), other({new_key}, "__Host-other");
  std::string copied = sent(other.set(session));
  copied.replace(0, copied.find('='), "__Host-dccast");
  EXPECT_FALSE(cookie.read(copied, now));
}

TEST(SessionCookie, FormerKeyStillOpens) {
  const std::string before = sent(SessionCookie({old_key}).set(session));
  EXPECT_TRUE(SessionCookie({new_key, old_key}).read(before, now));
  EXPECT_FALSE(SessionCookie({new_key}).read(before, now));

  const std::string after = sent(SessionCookie({new_key, old_key}).set(session));
  EXPECT_TRUE(SessionCookie({new_key}).read(after, now)) << "the first key seals";
}

TEST(CookieKeys, AreMadeKeptAndExchanged) {
  const std::filesystem::path file = testing::TempDir() + "cookie-keys-test/keys";
  std::filesystem::remove_all(file.parent_path());
  const auto first = cookie_keys(file, false);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(cookie_keys(file, false), first);
  EXPECT_EQ(std::filesystem::status(file).permissions(), std::filesystem::perms(0600));

  const auto second = cookie_keys(file, true);
  ASSERT_EQ(second.size(), 2U);
  EXPECT_EQ(second.back(), first.front());
  EXPECT_EQ(cookie_keys(file, true).back(), second.front());

  std::ofstream(file) << "nonsense\n";
  EXPECT_THROW(cookie_keys(file, false), CommandFailed);
  std::ofstream(file, std::ios::trunc).flush();
  EXPECT_THROW(cookie_keys(file, false), CommandFailed);
}

TEST(SignInAttempts, AreBoundedForEachAddressAndInAll) {
  SignInAttempts attempts;
  for (int i = 0; i < SignInAttempts::most_of_address; ++i)
    EXPECT_EQ(attempts.take("192.0.2.1", now), "");
  EXPECT_NE(attempts.take("192.0.2.1", now), "");
  EXPECT_EQ(attempts.take("192.0.2.2", now), "");
  EXPECT_EQ(attempts.take("192.0.2.1", now + 60), "") << "a minute later";

  for (int i = 1; i < SignInAttempts::most; ++i)
    EXPECT_EQ(attempts.take("2001:db8::" + std::to_string(i), now + 60), "");
  EXPECT_NE(attempts.take("192.0.2.3", now + 60), "");
}

}  // namespace
}  // namespace dccast::client
