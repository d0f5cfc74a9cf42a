#include "client/session/connection.hpp"

#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/session/failure.hpp"
#include "client/session/jobs.hpp"
#include "client/session/servers.hpp"
#include "fake_service.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr CallPolicy quick{4, std::chrono::milliseconds(1)};

struct Calls : testing::Test {
  FakeService service;
  Connection connection = service.connect();
  void SetUp() override {
    service.job.set_id("job");
    connection.set_policy(quick);
  }
};

TEST_F(Calls, ACheckThatWasKilledIsAskedForAgainAndSaysSo) {
  service.unavailable = 2;
  testing::internal::CaptureStderr();
  v1::ValidateCaseResponse response;
  EXPECT_TRUE(connection.try_call(&Stub::ValidateCase, v1::ValidateCaseRequest(), response).ok());
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(service.calls, 3);
  EXPECT_THAT(said, HasSubstr("(the check was killed); trying again (1 of 3)"));
  EXPECT_THAT(said, HasSubstr("trying again (2 of 3)"));
}

TEST_F(Calls, AttemptsAreBounded) {
  service.unavailable = 100;
  testing::internal::CaptureStderr();
  EXPECT_THROW(connection.call(&Stub::CancelJob, v1::CancelJobRequest()), CommandFailed);
  testing::internal::GetCapturedStderr();
  EXPECT_EQ(service.calls, 4);
}

TEST_F(Calls, ASubmissionIsRepeatedWithItsRequestId) {
  service.unavailable = 1;
  v1::SubmitJobRequest request;
  request.set_request_id("mine");
  v1::Job job;
  testing::internal::CaptureStderr();
  EXPECT_TRUE(submit_with_retries(connection, request, job).ok());
  testing::internal::GetCapturedStderr();
  EXPECT_EQ(service.submitted.request_id(), "mine");
  EXPECT_EQ(job.id(), "job");
}

TEST_F(Calls, WhatMayNotComeTwiceIsAskedOnce) {
  service.unavailable = 1;
  EXPECT_THROW(connection.call_once(&Stub::ResumeJob, v1::ResumeJobRequest()), CommandFailed);
  EXPECT_EQ(service.calls, 1);
}

TEST_F(Calls, NoProxyIsUsed) {
  ::setenv("http_proxy", "http://127.0.0.1:1", 1);
  ::setenv("grpc_proxy", "http://127.0.0.1:1", 1);
  Connection direct = service.connect();
  v1::GetJobRequest request;
  request.set_id("job");
  EXPECT_EQ(direct.call(&Stub::GetJob, request).id(), "job");
  ::unsetenv("http_proxy");
  ::unsetenv("grpc_proxy");
}

std::string said_of(grpc::StatusCode code, const std::string& message) {
  return failure_of({code, message}, "host:7117").what();
}

TEST(FailureText, ShowsNoTraceOfGrpc) {
  using grpc::StatusCode;
  EXPECT_THAT(said_of(StatusCode::UNAVAILABLE,
                      "failed to connect to all addresses; last error: UNKNOWN: "
                      "ipv4:127.0.0.1:1: Failed to connect to remote host: Connection refused"),
              HasSubstr("no answer from host:7117 (connection refused)"));
  EXPECT_THAT(said_of(StatusCode::UNAVAILABLE, "DNS resolution failed for host: C-ares status 4"),
              HasSubstr("the name of the host cannot be resolved"));
  EXPECT_THAT(said_of(StatusCode::INTERNAL, "ipv4:1.2.3.4:5: {grpc_status:13}"),
              Not(HasSubstr("ipv4")));
  EXPECT_THAT(said_of(StatusCode::UNIMPLEMENTED, ""), HasSubstr("another version"));
  EXPECT_THAT(said_of(StatusCode::INTERNAL, ""), HasSubstr("no reason given"));
  EXPECT_EQ(said_of(StatusCode::NOT_FOUND, "there is no job x"), "there is no job x");
  EXPECT_LT(said_of(StatusCode::INTERNAL, std::string(100000, 'x')).size(), 700u);
}

/// A refusal of the daemon with any text.
grpc::Status refused(grpc::StatusCode code, const refusal::Facts& facts, const std::string& text) {
  return {code, text, refusal::write_details(code, facts)};
}

TEST(FailureText, IsTheDaemonsWhateverWordsItHas) {
  const refusal::Facts facts{.reason = v1::ErrorInfo::NOT_FOUND, .cause = "x"};
  for (const char* text : {"Connection refused", "GOAWAY", "ipv4: is no label", "Socket closed"})
    EXPECT_EQ(failure_of(refused(grpc::NOT_FOUND, facts, text), "host:7117").what(),
              std::string(text));
}

TEST(Refusals, AreTakenByTheirReasonNotByTheirText) {
  const refusal::Facts facts{.reason = v1::ErrorInfo::ATTACHMENT_MISSING,
                             .cause = "c",
                             .limit = "l",
                             .permitted = "p",
                             .remedy = "r"};
  for (const char* text : {"", "no such file", "limits.maximum_queued = 3; submit again"}) {
    const grpc::Status status = refused(grpc::ABORTED, facts, text);
    EXPECT_TRUE(is_refused(status, v1::ErrorInfo::ATTACHMENT_MISSING));
    EXPECT_FALSE(is_refused(status, v1::ErrorInfo::LIMIT_REACHED));
    EXPECT_EQ(refusal_of(status)->limit, "l");
    EXPECT_EQ(refusal_of(status)->remedy, "r");
  }
  EXPECT_FALSE(refusal_of({grpc::ABORTED, "attachment is not on the server; upload it"}));
}

TEST(EnrolmentLine, HasThreeParts) {
  const std::string fingerprint = "/sha256:" + std::string(64, 'a') + "/";
  const auto line = read_enrolment_line("dccast login host:7117" + fingerprint + "secret\n");
  EXPECT_EQ(line.address, "host:7117");
  EXPECT_EQ(line.fingerprint, std::string(64, 'a'));
  EXPECT_EQ(line.secret, "secret");
  for (const std::string& without : {fingerprint + "secret", "host:7117" + fingerprint})
    EXPECT_THROW(read_enrolment_line(without), CommandFailed) << without;
}

}  // namespace
}  // namespace dccast::client
