// What users may do with jobs and studies of others, and how much they may have.
#include <gmock/gmock.h>

#include "tests/unit/service/service_fixture.hpp"

namespace dccast::service {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using enum grpc::StatusCode;

class OwnersTest : public ServiceTest {
protected:
  using ServiceTest::ServiceTest;
  static constexpr const char* study = "0f2b9a4e-0000-4000-8000-00000000000a";

  v1::SubmitJobRequest into_study() const {
    v1::SubmitJobRequest request = submission();
    request.set_study(study);
    return request;
  }

  User local_ = local_user(), anna_ = remote_user("anna"), bert_ = remote_user("bert");
};

TEST_F(OwnersTest, OnlyTheOwnerAndAnAdminChangeAJob) {
  const User kalle = remote_user("kalle", v1::ADMIN);
  const std::string id = submitted(anna_).id();
  const auto expect_refused = [&](const auto& method, const auto& request) {
    EXPECT_THAT(bert_.refusal(PERMISSION_DENIED, method, request).error_message(),
                AllOf(HasSubstr("of anna"), HasSubstr("kalle")));
  };
  expect_refused(&Stub::CancelJob, of<v1::CancelJobRequest>(id));
  expect_refused(&Stub::PauseJob, of<v1::PauseJobRequest>(id));
  expect_refused(&Stub::ResumeJob, of<v1::ResumeJobRequest>(id));
  expect_refused(&Stub::UpdateJob, of<v1::UpdateJobRequest>(id));
  expect_refused(&Stub::DeleteJob, of<v1::DeleteJobRequest>(id));
  bert_.ask(&Stub::GetJob, of<v1::GetJobRequest>(id));

  anna_.ask(&Stub::CancelJob, of<v1::CancelJobRequest>(id));
  ASSERT_TRUE(becomes(queue_, id, v1::CANCELLED));
  kalle.ask(&Stub::DeleteJob, of<v1::DeleteJobRequest>(id));
}

TEST_F(OwnersTest, NobodyElseSubmitsAJobForAStudyOrRequestsItAgain) {
  auto request = sweep(2, study);
  ASSERT_EQ(anna_.ask(&Stub::CreateStudy, request).id(), study);
  for (const User* other : {&bert_, &local_}) {
    EXPECT_THAT(other->refusal(PERMISSION_DENIED, &Stub::SubmitJob, into_study()).error_message(),
                HasSubstr("is of anna, and holds jobs of its owner alone"));
  }
  EXPECT_THAT(bert_.refusal(ALREADY_EXISTS, &Stub::CreateStudy, request).error_message(),
              HasSubstr("another user"));
  anna_.ask(&Stub::CreateStudy, request);
  submitted(anna_, into_study());
}

TEST_F(OwnersTest, WhoTakesTheTokenBackHasNone) {
  anna_.ask(&Stub::RevokeToken, v1::RevokeTokenRequest());
  anna_.refusal(UNAUTHENTICATED, &Stub::WhoAmI, v1::WhoAmIRequest());
  local_.refusal(FAILED_PRECONDITION, &Stub::RevokeToken, v1::RevokeTokenRequest());
}

v1::EnrolRequest enrolment(const std::string& secret, const std::string& machine = "laptop") {
  v1::EnrolRequest request;
  request.set_secret(secret);
  request.set_machine(machine);
  return request;
}

TEST_F(OwnersTest, AUserSignsInOnceMoreAndLosesNothing) {
  const std::int64_t now = std::time(nullptr);
  const auto line = anna_.ask(&Stub::IssueSignIn, v1::IssueSignInRequest());
  EXPECT_EQ(line.link(), "") << "no address of dccast-web is set";
  EXPECT_LE(line.expire_time().seconds() - now, 600 + 5);
  EXPECT_GE(line.expire_time().seconds() - now, 600);

  const auto bought = stranger().ask(&Stub::Enrol, enrolment(line.secret()));
  EXPECT_EQ(bought.user().name(), "anna");
  stranger().refusal(UNAUTHENTICATED, &Stub::Enrol, enrolment(line.secret()));
  anna_.ask(&Stub::WhoAmI, v1::WhoAmIRequest());
  EXPECT_EQ(stranger(bought.token()).ask(&Stub::WhoAmI, v1::WhoAmIRequest()).name(), "anna");
  EXPECT_THAT(storage::read_file(folder_ / "audit.log"),
              ::testing::ContainsRegex("anna.*IssueSignIn.*a secret was made"));
}

TEST_F(OwnersTest, ALineOfAnotherTimeIsWorthNothing) {
  const auto line = anna_.ask(&Stub::IssueSignIn, v1::IssueSignInRequest());
  std::string token;
  const std::int64_t late = line.expire_time().seconds();
  EXPECT_FALSE(users_.enrol(line.secret(), "", late, late + 1000, token).proven());
  EXPECT_TRUE(users_.enrol(line.secret(), "", late - 1, late + 1000, token).proven());
}

TEST_F(OwnersTest, WhoIsNotListedSignsInNowhereElse) {
  EXPECT_THAT(local_.refusal(FAILED_PRECONDITION, &Stub::IssueSignIn, v1::IssueSignInRequest())
                  .error_message(),
              HasSubstr("dccastd user add"));
  EXPECT_TRUE(local_.ask(&Stub::ListTokens, v1::ListTokensRequest()).tokens().empty());
  v1::RevokeTokenRequest revoked;
  revoked.set_id("0123456789abcdef");
  local_.refusal(NOT_FOUND, &Stub::RevokeToken, revoked);
}

TEST_F(OwnersTest, AUserListsOwnTokensAndEndsThem) {
  const std::string secret = anna_.ask(&Stub::IssueSignIn, v1::IssueSignInRequest()).secret();
  const User laptop = stranger(stranger().ask(&Stub::Enrol, enrolment(secret)).token());
  anna_.ask(&Stub::IssueSignIn, v1::IssueSignInRequest());

  auto tokens = anna_.ask(&Stub::ListTokens, v1::ListTokensRequest()).tokens();
  ASSERT_EQ(tokens.size(), 3);
  EXPECT_EQ(tokens[0].name(), "desk");
  EXPECT_TRUE(tokens[0].is_of_this_call());
  EXPECT_EQ(tokens[0].last_use_address(), "192.0.2.1");
  EXPECT_LT(std::time(nullptr) - tokens[0].last_use_time().seconds(), 5);
  EXPECT_EQ(tokens[1].name(), "laptop");
  EXPECT_FALSE(tokens[1].is_of_this_call() || tokens[1].is_secret());
  EXPECT_FALSE(tokens[1].has_last_use_time());
  EXPECT_TRUE(tokens[2].is_secret());

  v1::RevokeTokenRequest revoked;
  revoked.set_id(tokens[1].id());
  bert_.refusal(NOT_FOUND, &Stub::RevokeToken, revoked);
  laptop.ask(&Stub::WhoAmI, v1::WhoAmIRequest());
  anna_.ask(&Stub::RevokeToken, revoked);
  laptop.refusal(UNAUTHENTICATED, &Stub::WhoAmI, v1::WhoAmIRequest());
  anna_.refusal(NOT_FOUND, &Stub::RevokeToken, revoked);
  EXPECT_EQ(anna_.ask(&Stub::ListTokens, v1::ListTokensRequest()).tokens_size(), 2);
}

TEST_F(OwnersTest, TokensOfAUserAreBounded) {
  const std::int64_t now = std::time(nullptr);
  for (int i = 1; i < 100; ++i) users_.add_line("anna", "", now, now + 1000);
  EXPECT_THAT(anna_.refusal(RESOURCE_EXHAUSTED, &Stub::IssueSignIn, v1::IssueSignInRequest())
                  .error_message(),
              AllOf(HasSubstr("anna has 100 tokens"), HasSubstr("dccast tokens --end")));
}

TEST_F(OwnersTest, WithoutARightTokenNothingIsAnswered) {
  for (const std::string& token :
       {std::string(), "dccast-token-" + std::string(16, '0') + "-" + std::string(64, '0'),
        std::string("x"), std::string(5000, 'x')}) {
    EXPECT_THAT(stranger(token)
                    .refusal(UNAUTHENTICATED, &Stub::GetServerInfo, v1::GetServerInfoRequest())
                    .error_message(),
                HasSubstr("dccast login"));
  }
}

TEST_F(OwnersTest, WhatChangesOfAUserHoldsAtOnce) {
  submitted(anna_);
  users_.set_role("anna", v1::VIEWER);
  EXPECT_THAT(anna_.refusal(PERMISSION_DENIED, &Stub::SubmitJob, submission()).error_message(),
              AllOf(HasSubstr("anna has the role viewer"), HasSubstr("SubmitJob needs submitter"),
                    HasSubstr(user_name(::geteuid()))));

  users_.set_disabled("anna", true);
  EXPECT_THAT(
      anna_.refusal(UNAUTHENTICATED, &Stub::ListJobs, v1::ListJobsRequest()).error_message(),
      HasSubstr("disabled"));
  users_.set_disabled("anna", false);
  listed(anna_);
}

TEST_F(OwnersTest, AViewerUploadsNothing) {
  v1::Attachment file;
  file.set_name("slab.msh");
  file.set_sha256(std::string(64, '0'));
  const auto status = remote_user("vera", v1::VIEWER).upload(file, {std::string(100'000, 'x')});
  EXPECT_EQ(status.error_code(), PERMISSION_DENIED);
  EXPECT_THAT(status.error_message(), HasSubstr("viewer"));
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "uploads"));
}

class WhereUsersReadTheirOwn : public OwnersTest {
protected:
  WhereUsersReadTheirOwn()
      : OwnersTest([](auto& settings) { settings.mutable_access()->set_read(v1::OWN); }) {}
};

TEST_F(WhereUsersReadTheirOwn, NothingTellsOfJobsOfOthers) {
  const std::string id = submitted(anna_).id();
  EXPECT_THAT(listed(anna_), ElementsAre(id));
  EXPECT_THAT(listed(bert_), IsEmpty());
  EXPECT_THAT(listed(local_), ElementsAre(id)) << "an admin";

  const auto expect_unknown = [&](const auto& method, const auto& request) {
    EXPECT_EQ(bert_.refusal(NOT_FOUND, method, request).error_message(),
              "there is no job " + id + " here; the list of jobs names those there are");
  };
  expect_unknown(&Stub::GetJob, of<v1::GetJobRequest>(id));
  expect_unknown(&Stub::WatchJob, of<v1::WatchJobRequest>(id));
  expect_unknown(&Stub::CancelJob, of<v1::CancelJobRequest>(id));
  expect_unknown(&Stub::DeleteJob, of<v1::DeleteJobRequest>(id));
  v1::CompareRunsRequest compared;
  for (int run = 0; run < 2; ++run) compared.add_runs()->set_job(id);
  expect_unknown(&Stub::CompareRuns, compared);
  EXPECT_THAT(storage::read_file(folder_ / "audit.log"),
              ::testing::ContainsRegex("bert.*GetJob.*NOT_FOUND|GetJob.*bert.*NOT_FOUND"));

  v1::ListJobsRequest jobs;
  jobs.set_owner("anna");
  bert_.refusal(PERMISSION_DENIED, &Stub::ListJobs, jobs);
  v1::ListStudiesRequest studies;
  studies.set_owner("anna");
  bert_.refusal(PERMISSION_DENIED, &Stub::ListStudies, studies);

  v1::SubmitJobRequest after = submission();
  after.add_after(id);
  bert_.refusal(NOT_FOUND, &Stub::SubmitJob, after);
  submitted(anna_, after);
}

TEST_F(WhereUsersReadTheirOwn, CastingsOfOthersAreNotReadByWayOfAnOwnStudy) {
  anna_.ask(&Stub::CreateStudy, sweep(2, study));
  const std::string own = bert_.ask(&Stub::CreateStudy, sweep(2, "of-bert")).id();
  v1::CalibratedCasting of_bert, of_anna;
  of_bert.add_studies(own);
  of_anna.add_studies(study);

  auto judged = of<v1::JudgeStudyRequest>(own);
  *judged.add_castings() = of_bert;
  bert_.ask(&Stub::JudgeStudy, judged);
  *judged.add_castings() = of_anna;
  bert_.refusal(NOT_FOUND, &Stub::JudgeStudy, judged);
  auto evaluated = of<v1::EvaluateStudyRequest>(own);
  *evaluated.mutable_castings() = judged.castings();
  bert_.refusal(NOT_FOUND, &Stub::EvaluateStudy, evaluated);
}

class UserLimits : public OwnersTest {
protected:
  UserLimits()
      : OwnersTest([](v1::DaemonConfig& settings) {
          settings.mutable_per_user()->set_maximum_queued(2);
          settings.mutable_per_user()->set_maximum_streams(2);
        }) {}
};

TEST_F(UserLimits, JobsOfOneUser) {
  submitted(anna_);
  queue_.executor.wait_for_launch(1);
  submitted(anna_);
  EXPECT_THAT(anna_.refusal(RESOURCE_EXHAUSTED, &Stub::SubmitJob, submission()).error_message(),
              AllOf(HasSubstr("anna has 2 jobs"), HasSubstr("per_user.maximum_queued = 2")));
  v1::QueryButtCurlRequest query;
  *query.mutable_case_() = sound_case();
  query.set_keep(true);
  anna_.refusal(RESOURCE_EXHAUSTED, &Stub::QueryButtCurl, query);
  submitted(local_);
}

TEST_F(UserLimits, StreamsOfOneUser) {
  const auto request = of<v1::WatchJobRequest>(submitted(anna_).id());
  // A stream that has brought its first event is open.
  struct Held {
    Held(const User& user, const v1::WatchJobRequest& request)
        : call(user.context()), reader(user.stub().WatchJob(call.get(), request)) {
      v1::JobEvent event;
      opened = reader->Read(&event);
    }
    ~Held() { call->TryCancel(); }
    std::unique_ptr<grpc::ClientContext> call;
    std::unique_ptr<grpc::ClientReader<v1::JobEvent>> reader;
    bool opened = false;
  };
  auto first = std::make_unique<Held>(anna_, request);
  const Held second(anna_, request);
  ASSERT_TRUE(first->opened && second.opened);
  EXPECT_THAT(anna_.refusal(RESOURCE_EXHAUSTED, &Stub::WatchJob, request).error_message(),
              HasSubstr("per_user.maximum_streams = 2"));
  EXPECT_TRUE(Held(bert_, request).opened);

  first.reset();
  EXPECT_TRUE(eventually([&] { return Held(anna_, request).opened; }));
}

class CallLimits : public OwnersTest {
protected:
  CallLimits()
      : OwnersTest([](v1::DaemonConfig& settings) {
          settings.mutable_per_user()->set_maximum_calls_per_s(2);
        }) {}
};

TEST_F(CallLimits, CallsASecond) {
  int answered = 0, refused = 0;
  for (int i = 0; i < 40; ++i) {
    v1::WhoAmIResponse response;
    const auto status = anna_.stub().WhoAmI(anna_.context().get(), {}, &response);
    (status.ok() ? answered : refused)++;
    EXPECT_TRUE(status.ok() || status.error_code() == RESOURCE_EXHAUSTED);
  }
  EXPECT_GE(answered, 20);
  EXPECT_GT(refused, 0);
}

class DiskLimit : public OwnersTest {
protected:
  DiskLimit()
      : OwnersTest([](v1::DaemonConfig& settings) {
          settings.mutable_per_user()->set_maximum_disk_bytes(2000);
        }) {}
};

TEST_F(DiskLimit, WhoHoldsTooMuchSubmitsNoMore) {
  const std::string id = ended_job(anna_, submission(), std::vector(100, step(1, 0.0))).id();
  EXPECT_THAT(anna_.refusal(RESOURCE_EXHAUSTED, &Stub::SubmitJob, submission()).error_message(),
              AllOf(HasSubstr("anna"), HasSubstr("per_user.maximum_disk = 2000 bytes"),
                    HasSubstr("dccast delete")));
  submitted(bert_);
  anna_.ask(&Stub::DeleteJob, of<v1::DeleteJobRequest>(id));
  submitted(anna_);
}

}  // namespace
}  // namespace dccast::service
