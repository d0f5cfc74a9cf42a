#include "server/access/rules.hpp"

#include <gtest/gtest.h>

#include <set>

#include "dccast/v1/service.pb.h"
#include "tests/support/temporary_folder.hpp"

namespace dccast::access {
namespace {

constexpr std::int64_t now = 1'800'000'000;
constexpr std::int64_t day = 86400;

const google::protobuf::ServiceDescriptor& service() {
  return *v1::SubmitJobRequest::descriptor()->file()->FindServiceByName("SimulationService");
}

TEST(Rules, EveryCallHasOneAndARequestOfItsOwn) {
  std::set<const google::protobuf::Descriptor*> requests;
  for (int i = 0; i < service().method_count(); ++i) {
    const auto& method = *service().method(i);
    EXPECT_TRUE(method.options().HasExtension(v1::access)) << method.name();
    const v1::CallAccess& access = method.options().GetExtension(v1::access);
    EXPECT_NE(access.role(), v1::ROLE_UNSPECIFIED) << method.name();
    EXPECT_TRUE(requests.insert(method.input_type()).second) << method.name();
    EXPECT_EQ(rule_of(*method.input_type()).name, method.name());
    if (access.touches() != v1::NOTHING) {
      EXPECT_NE(method.input_type()->FindFieldByName("id"), nullptr) << method.name();
    }
    EXPECT_EQ(access.role() == v1::ANYONE, method.name() == "Enrol") << method.name();
  }
}

TEST(Rules, ARequestOfNoCallNeedsAnAdmin) {
  EXPECT_EQ(rule_of(*v1::Job::descriptor()).access.role(), v1::ADMIN);
}

/// What reads and what changes, by the names that calls have.
TEST(Rules, CallsThatChangeNeedASubmitter) {
  for (int i = 0; i < service().method_count(); ++i) {
    const std::string name = service().method(i)->name();
    const v1::CallAccess& access = rule_of(*service().method(i)->input_type()).access;
    for (const char* verb :
         {"Submit", "Upload", "Create", "Cancel", "Pause", "Resume", "Restart", "Delete"})
      EXPECT_TRUE(!name.starts_with(verb) || access.role() >= v1::SUBMITTER) << name;
    for (const char* verb : {"Cancel", "Pause", "Resume", "Restart", "Delete"})
      if (name.starts_with(verb)) {
        EXPECT_EQ(access.touches(), name.ends_with("Study")  ? v1::CHANGES_STUDY
                                    : name.ends_with("Line") ? v1::CHANGES_LINE
                                                             : v1::CHANGES_JOB);
      }
  }
}

struct AuthorityTest : ::testing::Test {
  TemporaryFolder folder;
  UserStore users{folder.path()};
  Authority authority{users, {.local_role = v1::SUBMITTER, .own_user = "dccast"}};
  const CallRule& cancel = rule_of(*v1::CancelJobRequest::descriptor());
  const CallRule& get = rule_of(*v1::GetJobRequest::descriptor());
  const CallRule& submit = rule_of(*v1::SubmitJobRequest::descriptor());
};

TEST_F(AuthorityTest, TheDaemonsOwnUserAndRootAreAdmins) {
  EXPECT_EQ(authority.local_user("root").role, v1::ADMIN);
  EXPECT_EQ(authority.local_user("dccast").role, v1::ADMIN);
  EXPECT_EQ(authority.local_user("nobody").role, v1::SUBMITTER);
  EXPECT_EQ(authority.local_user("").role, v1::SUBMITTER);
}

TEST_F(AuthorityTest, AListedLocalUserHasTheRoleOfTheList) {
  users.add("anna", v1::VIEWER, now, now + day);
  EXPECT_EQ(authority.local_user("anna").role, v1::VIEWER);
  users.set_disabled("anna", true);
  EXPECT_FALSE(authority.local_user("anna").proven());
}

TEST_F(AuthorityTest, ARoleTooLowNamesUserRoleNeedAndAdmins) {
  users.add("kalle", v1::ADMIN, now, now + day);
  const Caller anna{.name = "anna", .role = v1::VIEWER};
  const std::string fault = authority.role_fault(anna, submit).value().message();
  for (const char* part : {"anna has the role viewer", "SubmitJob needs submitter", "kalle"})
    EXPECT_NE(fault.find(part), std::string::npos) << fault;
  EXPECT_FALSE(authority.role_fault(anna, get));
}

TEST_F(AuthorityTest, OnlyTheOwnerOrAnAdminChanges) {
  const Caller anna{.name = "anna", .role = v1::SUBMITTER};
  EXPECT_FALSE(authority.owner_fault(anna, cancel, "anna", "job 1"));
  const std::string fault = authority.owner_fault(anna, cancel, "bert", "job 1").value().message();
  for (const char* part : {"job 1 is of bert", "anna (submitter)", "ask bert"})
    EXPECT_NE(fault.find(part), std::string::npos) << fault;
  EXPECT_FALSE(
      authority.owner_fault({.name = "kalle", .role = v1::ADMIN}, cancel, "bert", "job 1"));
  EXPECT_FALSE(authority.owner_fault(anna, get, "bert", "job 1"));
}

// Neither a job nor a caller without a name belongs to the other.
TEST_F(AuthorityTest, NoNameIsNoOwner) {
  EXPECT_TRUE(authority.owner_fault({.role = v1::SUBMITTER}, cancel, "", "job 1"));
}

TEST_F(AuthorityTest, ReadingIsOneOwnWhereTheSettingsHaveIt) {
  Authority strict(users, {.own_user = "dccast", .reads_own_only = true});
  const Caller anna{.name = "anna", .role = v1::SUBMITTER};
  EXPECT_TRUE(strict.owner_fault(anna, get, "bert", "job 1"));
  EXPECT_FALSE(strict.owner_fault(anna, get, "anna", "job 1"));
  EXPECT_TRUE(strict.reads_own_only(anna));
  EXPECT_FALSE(strict.reads_own_only({.name = "kalle", .role = v1::ADMIN}));
}

TEST_F(AuthorityTest, AProvenCallerLapses) {
  std::string token;
  users.enrol(users.add("anna", v1::SUBMITTER, now, now + day), "", now, now + day, token);
  const Caller anna = authority.by_token(token, now);
  ASSERT_TRUE(anna.proven());
  EXPECT_FALSE(authority.lapse(anna, now));
  EXPECT_NE(authority.lapse(anna, now + day).value().cause.find("expired"), std::string::npos);
  users.revoke("anna", anna.credential);
  EXPECT_NE(authority.lapse(anna, now).value().cause.find("revoked"), std::string::npos);
  users.remove("anna");
  EXPECT_NE(authority.lapse(anna, now).value().cause.find("removed"), std::string::npos);
}

TEST_F(AuthorityTest, AnOwnerWhoIsDisabledOrRemovedHasNoJobAnyMore) {
  v1::Job job;
  job.set_owner("anna");
  EXPECT_EQ(authority.refusal_of_owner(job), "") << "a local user need not be listed";
  users.add("anna", v1::SUBMITTER, now, now + day);
  EXPECT_EQ(authority.refusal_of_owner(job), "");
  users.set_disabled("anna", true);
  EXPECT_EQ(authority.refusal_of_owner(job), "user anna is disabled");
  users.remove("anna");
  EXPECT_EQ(authority.refusal_of_owner(job), "");
  job.set_owner_is_listed(true);
  EXPECT_EQ(authority.refusal_of_owner(job), "user anna was removed");
}

TEST_F(AuthorityTest, ADisabledAdminOfAnotherMachineIsOneNoLonger) {
  std::string token;
  users.enrol(users.add("kalle", v1::ADMIN, now, now + day), "", now, now + day, token);
  const Caller kalle = authority.by_token(token, now);
  ASSERT_EQ(kalle.role, v1::ADMIN);
  users.set_disabled("kalle", true);
  EXPECT_TRUE(authority.lapse(kalle, now));
  EXPECT_FALSE(authority.by_certificate("kalle", now + day, now).proven());
}

TEST_F(AuthorityTest, ACertificateStandsForAListedUser) {
  EXPECT_FALSE(authority.by_certificate("anna", now + day, now).proven());
  users.add("anna", v1::VIEWER, now, now + day);
  const Caller anna = authority.by_certificate("anna", now + day, now);
  EXPECT_TRUE(anna.proven());
  EXPECT_EQ(anna.role, v1::VIEWER);
  EXPECT_TRUE(authority.lapse(anna, now + day));
  users.set_disabled("anna", true);
  EXPECT_FALSE(authority.by_certificate("anna", now + day, now).proven());
}

}  // namespace
}  // namespace dccast::access
