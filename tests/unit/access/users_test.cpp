#include "server/access/users.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <thread>

#include "core/storage/file.hpp"
#include "core/storage/file_lock.hpp"
#include "core/storage/storage_error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::access {
namespace {

constexpr std::int64_t now = 1'800'000'000;
constexpr std::int64_t day = 86400;

struct Users : ::testing::Test {
  TemporaryFolder folder;
  UserStore store{folder.path()};

  std::string token_of(const std::string& name, v1::Role role = v1::SUBMITTER) {
    const std::string secret = store.add(name, role, now, now + day);
    std::string token;
    EXPECT_TRUE(store.enrol(secret, "desk", now, now + 90 * day, token).proven());
    return token;
  }
};

TEST_F(Users, ASecretBuysOneTokenOnce) {
  const std::string secret = store.add("anna", v1::SUBMITTER, now, now + day);
  std::string token, second;
  const Caller first = store.enrol(secret, "desk", now, now + day, token);
  ASSERT_TRUE(first.proven());
  EXPECT_EQ(first.name, "anna");
  const Caller again = store.enrol(secret, "desk", now, now + day, second);
  EXPECT_FALSE(again.proven());
  EXPECT_NE(again.refusal.value().cause.find("used before"), std::string::npos)
      << again.refusal->cause;
  EXPECT_TRUE(second.empty());
  const Caller proof = store.prove(token, now);
  ASSERT_TRUE(proof.proven());
  EXPECT_EQ(proof.role, v1::SUBMITTER);
}

TEST_F(Users, AnEnrolmentSecretIsNoToken) {
  const std::string secret = store.add("anna", v1::SUBMITTER, now, now + day);
  EXPECT_FALSE(store.prove(secret, now).proven());
}

TEST_F(Users, ATokenBuysTheNextOneUntilItsEnd) {
  const std::string first = token_of("anna");
  std::string second, third;
  ASSERT_TRUE(store.enrol(first, "laptop", now + day, now + 91 * day, second).proven());
  EXPECT_TRUE(store.prove(first, now + day).proven()) << "until its client has stored the new one";
  EXPECT_TRUE(store.prove(second, now + 90 * day).proven());
  EXPECT_EQ(store.find("anna")->credential(1).machine(), "desk") << "it keeps its name";
  EXPECT_FALSE(store.enrol(first, "", now + 90 * day, now + 180 * day, third).proven());
  EXPECT_TRUE(third.empty());
}

TEST_F(Users, AFurtherLineRevokesNothingAndNamesItsToken) {
  const std::string first = token_of("anna");
  const std::string secret = store.add_line("anna", "night script", now, now + day);
  std::string second;
  ASSERT_TRUE(store.enrol(secret, "desk", now, now + 90 * day, second).proven());
  EXPECT_TRUE(store.prove(first, now).proven());
  EXPECT_TRUE(store.prove(second, now).proven());
  const v1::User anna = store.find("anna").value();
  ASSERT_EQ(anna.credential_size(), 2);
  EXPECT_EQ(anna.credential(0).machine(), "desk");
  EXPECT_EQ(anna.credential(1).machine(), "night script");
  EXPECT_THROW(store.add_line("carl", "", now, now + day), Refused);
}

TEST_F(Users, TheOldestSessionOfABrowserGivesWayAtTheLimit) {
  const std::string desk = token_of("anna");
  const auto signed_in = [&] {
    std::string token;
    store.enrol(store.add_line("anna", "", now, now + day), "web", now, now + 90 * day, token);
    return token;
  };
  const std::string oldest = signed_in(), second = signed_in();
  for (int i = 3; i < 100; ++i) signed_in();
  EXPECT_TRUE(store.prove(oldest, now).proven());

  EXPECT_TRUE(store.prove(signed_in(), now).proven());
  EXPECT_FALSE(store.prove(oldest, now).proven());
  EXPECT_TRUE(store.prove(second, now).proven());
  EXPECT_TRUE(store.prove(desk, now).proven());
}

TEST_F(Users, SecretsExpire) {
  const std::string secret = store.add("anna", v1::SUBMITTER, now, now + day);
  std::string token;
  const Caller late = store.enrol(secret, "", now + day, now + 2 * day, token);
  EXPECT_NE(late.refusal.value().cause.find("has expired"), std::string::npos)
      << late.refusal->cause;
  ASSERT_TRUE(store.enrol(secret, "", now, now + day, token).proven());
  EXPECT_TRUE(store.prove(token, now + day - 1).proven());
  const Caller expired = store.prove(token, now + day);
  EXPECT_NE(expired.refusal.value().cause.find("of anna has expired"), std::string::npos)
      << expired.refusal->cause;
}

TEST_F(Users, NoSecretStandsInTheFile) {
  const std::string token = token_of("anna");
  const std::string file = storage::read_file(folder / "users.toml");
  EXPECT_EQ(file.find(token.substr(token.size() - 64)), std::string::npos);
  EXPECT_NE(file.find("anna"), std::string::npos);
  struct stat status;
  ASSERT_EQ(::stat((folder / "users.toml").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600);
}

TEST_F(Users, AWrongSecretWithARightIdIsUnknown) {
  std::string token = token_of("anna");
  token.back() = token.back() == '0' ? '1' : '0';
  EXPECT_FALSE(store.prove(token, now).proven());
  EXPECT_FALSE(store.prove("", now).proven());
  EXPECT_FALSE(store.prove("dccast-token-", now).proven());
}

// A command is another process: it has a store of its own on the same file.
TEST_F(Users, WhatAnotherProcessChangesHoldsAtOnce) {
  const std::string token = token_of("anna");
  ASSERT_TRUE(store.prove(token, now).proven());
  UserStore command(folder.path());
  command.set_disabled("anna", true);
  EXPECT_NE(store.prove(token, now).refusal.value().cause.find("disabled"), std::string::npos);
  command.set_disabled("anna", false);
  EXPECT_TRUE(store.prove(token, now).proven());
  command.set_role("anna", v1::VIEWER);
  EXPECT_EQ(store.prove(token, now).role, v1::VIEWER);
  command.rotate("anna", now, now + day);
  EXPECT_FALSE(store.prove(token, now).proven());
}

TEST_F(Users, ARemovedUserIsGoneWithItsTokens) {
  const std::string anna = token_of("anna"), bert = token_of("bert");
  store.remove("anna");
  EXPECT_FALSE(store.prove(anna, now).proven());
  EXPECT_TRUE(store.prove(bert, now).proven());
  EXPECT_FALSE(store.find("anna"));
  EXPECT_THROW(store.remove("anna"), Refused);
}

TEST_F(Users, TheLastUserIsRemovedAndAnotherAdded) {
  store.add("anna", v1::VIEWER, now, now + day);
  store.remove("anna");
  EXPECT_EQ(UserStore(folder.path()).users().user_size(), 0);
  store.add("bert", v1::VIEWER, now, now + day);
  EXPECT_EQ(store.users().user_size(), 1);
}

TEST_F(Users, ATokenIsRevokedAlone) {
  const std::string token = token_of("anna");
  const std::string id = store.prove(token, now).credential;
  EXPECT_TRUE(store.revoke("anna", id));
  EXPECT_FALSE(store.revoke("anna", id));
  EXPECT_FALSE(store.prove(token, now).proven());
}

TEST_F(Users, NamesAreHeldToWhatLinesAndPathsTake) {
  for (const char* name : {"", "a b", "a\nb", "-x", "\xc3\xa4", "a/b"})
    EXPECT_THROW(store.add(name, v1::VIEWER, now, now + day), Refused) << name;
  EXPECT_THROW(store.add(std::string(65, 'a'), v1::VIEWER, now, now + day), Refused);
  store.add("anna.b@plant", v1::VIEWER, now, now + day);
  EXPECT_THROW(store.add("anna.b@plant", v1::VIEWER, now, now + day), Refused);
}

TEST_F(Users, ADamagedFileLetsNoOneIn) {
  const std::string token = token_of("anna");
  storage::write_file(folder / "users.toml", "[[user]\nname =");
  EXPECT_THROW(store.prove(token, now), Refused);
}

TEST_F(Users, NoChangeIsLostBetweenProcesses) {
  const auto add_some = [this](const std::string& prefix) {
    UserStore other(folder.path());
    for (int i = 0; i < 20; ++i) other.add(prefix + std::to_string(i), v1::VIEWER, now, now + day);
  };
  std::thread first([&] { add_some("a"); });
  std::thread second([&] { add_some("b"); });
  first.join();
  second.join();
  EXPECT_EQ(store.users().user_size(), 40);
}

/// Such a lock once held up all calls: that of the file was awaited under the mutex of the readers.
TEST_F(Users, ALockThatAnotherProcessKeepsStopsChangesForASecondAndNoReader) {
  const std::string token = token_of("anna");
  const storage::FileLock kept(folder / "users.lock", std::chrono::milliseconds(0));
  ASSERT_TRUE(kept);

  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  std::thread changing([&] {
    try {
      store.add("berta", v1::VIEWER, now, now + day);
      ADD_FAILURE() << "was changed without the lock";
    } catch (const storage::StorageError& error) {
      EXPECT_NE(std::string(error.what()).find("is locked by another process"), std::string::npos);
    }
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // it waits for the lock by then
  EXPECT_TRUE(store.prove(token, now).proven());
  EXPECT_LT(elapsed_s(), 0.9);
  changing.join();
  EXPECT_LT(elapsed_s(), 3.0);
}

TEST_F(Users, TheMachineIsOneShortLine) {
  const std::string secret = store.add("anna", v1::VIEWER, now, now + day);
  std::string token;
  ASSERT_TRUE(store.enrol(secret, "a\nb" + std::string(1000, 'x'), now, now + day, token).proven());
  const std::string machine = store.find("anna")->credential(0).machine();
  EXPECT_LE(machine.size(), 255u);
  EXPECT_EQ(machine.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace dccast::access
