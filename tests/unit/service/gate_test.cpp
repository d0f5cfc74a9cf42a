#include "server/service/gate.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <memory>

#include "core/storage/file.hpp"
#include "dccast/v1/line.pb.h"
#include "dccast/v1/service.pb.h"
#include "dccast/v1/study.pb.h"
#include "server/service/refusals.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::service {
namespace {

class GateTest : public ::testing::Test {
protected:
  /// Number of lines in the audit log after these calls with this outcome.
  std::ptrdiff_t lines_after(int calls, const access::Caller& caller, grpc::StatusCode code,
                             const google::protobuf::Descriptor& request) {
    for (int i = 0; i < calls; ++i)
      gate_.record({}, caller, access::rule_of(request), "ipv4:127.0.0.9:1",
                   code == grpc::OK ? grpc::Status::OK : grpc::Status(code, "why"));
    const std::string text = storage::read_file(folder_ / "audit.log");
    return std::count(text.begin(), text.end(), '\n');
  }

  TemporaryFolder folder_;
  access::UserStore users_{folder_.path()};
  access::Authority authority_{users_, {}};
  access::AuditLog audit_{folder_.path()};
  Gate gate_{authority_, audit_, {}, {}};
  const access::Caller anna_{.name = "anna", .role = v1::SUBMITTER};
  const access::Caller stranger_{.refusal = access::not_proven("this call has no token", "log in")};
};

constexpr int many = 5000;
constexpr std::ptrdiff_t most = 200;  // ten a second for ten seconds at once, and what comes after

/// Unauthenticated clients may call Enrol as often as a connection permits.
TEST_F(GateTest, RefusedCallsDoNotFillTheAuditLog) {
  for (const auto code : {grpc::RESOURCE_EXHAUSTED, grpc::UNAUTHENTICATED, grpc::INVALID_ARGUMENT,
                          grpc::FAILED_PRECONDITION})
    EXPECT_LT(lines_after(many, stranger_, code, *v1::EnrolRequest::descriptor()), most)
        << int(code);
}

TEST_F(GateTest, AStrangersRefusalsHideNoUsers) {
  lines_after(many, stranger_, grpc::RESOURCE_EXHAUSTED, *v1::EnrolRequest::descriptor());
  const auto before =
      lines_after(0, stranger_, grpc::RESOURCE_EXHAUSTED, *v1::EnrolRequest::descriptor());
  EXPECT_EQ(lines_after(1, anna_, grpc::PERMISSION_DENIED, *v1::DeleteJobRequest::descriptor()),
            before + 1);
}

TEST_F(GateTest, ATokenOverTheUnixSocketMustBeOfTheUserOfTheSocket) {
  const std::time_t now = std::time(nullptr);
  const std::string own_name = user_name(::getuid());
  const auto token_of = [&](const std::string& name) {
    std::string token;
    users_.enrol(users_.add(name, v1::VIEWER, now, now + 60), "", now, now + 60, token);
    return token;
  };
  const std::string own = token_of(own_name), other = token_of("kalle");

  const auto socket = std::make_shared<relay::Peer>();
  socket->user_id = ::getuid();
  const auto identified = [&](const std::string& token) {
    return gate_.identify({.peer = socket, .token = token});
  };
  EXPECT_TRUE(identified("").proven());
  EXPECT_TRUE(identified(own).proven());
  EXPECT_EQ(identified(own).by, access::ProvenBy::local_user);

  EXPECT_FALSE(identified("no token of ours").proven());
  const access::Caller foreign = identified(other);
  ASSERT_FALSE(foreign.proven());
  EXPECT_EQ(foreign.refusal->cause,
            "the token of this call is of kalle, and the socket is of " + own_name);
}

TEST_F(GateTest, EveryChangeIsRecorded) {
  EXPECT_EQ(lines_after(500, anna_, grpc::OK, *v1::DeleteJobRequest::descriptor()), 500);
  EXPECT_EQ(lines_after(500, anna_, grpc::OK, *v1::GetJobRequest::descriptor()), 500);
}

/// Who reads only what is their own does not learn whether another's is there, nor whose it is.
TEST_F(GateTest, WhatOneMayNotReadIsRefusedAsWhatIsNotThere) {
  access::Authority strict(users_, {.reads_own_only = true});
  const auto of_bert = [](const std::string& id) {
    return id == "none" ? std::nullopt : std::optional<std::string>("bert");
  };
  const Gate::Owners owners{.job = of_bert, .study = of_bert, .line = of_bert};
  Gate hiding(strict, audit_, {}, owners), open(authority_, audit_, {}, owners);

  for (const auto* request :
       {v1::GetJobRequest::descriptor(), v1::DeleteJobRequest::descriptor(),
        v1::GetStudyRequest::descriptor(), v1::CancelStudyRequest::descriptor(),
        v1::GetLineRequest::descriptor(), v1::DeleteLineRequest::descriptor()}) {
    const access::CallRule& rule = access::rule_of(*request);
    const grpc::Status hidden = hiding.permit_touch(anna_, rule, "x");
    const grpc::Status missing = rule.touches_line()    ? unknown_line("x")
                                 : rule.touches_study() ? unknown_study("x")
                                                        : unknown_job("x");
    EXPECT_EQ(hidden.error_code(), grpc::NOT_FOUND) << rule.name;
    EXPECT_EQ(hidden.error_message(), missing.error_message()) << rule.name;
    // Parts of the details have no order.
    EXPECT_EQ(hidden.error_details().size(), missing.error_details().size()) << rule.name;

    EXPECT_TRUE(hiding.permit_touch(anna_, rule, "none").ok());
    EXPECT_EQ(open.permit_touch(anna_, rule, "x").error_code(),
              rule.changes() ? grpc::PERMISSION_DENIED : grpc::OK);
  }
}

/// The label of the metric is the limit that the refusal names, whatever its text.
TEST_F(GateTest, ARefusalIsCountedByItsLimitNotByItsText) {
  const refusal::Facts full{
      .reason = v1::ErrorInfo::LIMIT_REACHED, .cause = "full", .limit = "limits.maximum_queued"};
  const refusal::Facts no_limit{.reason = v1::ErrorInfo::STORAGE_FULL,
                                .cause = "limits.maximum_queued and limits.minimum_free"};
  for (const char* text : {"", "limits.maximum_streams = 3", "anything"})
    gate_.count(
        "SubmitJob",
        {grpc::RESOURCE_EXHAUSTED, text, refusal::write_details(grpc::RESOURCE_EXHAUSTED, full)},
        {});
  gate_.count("SubmitJob", make_status(no_limit), {});
  gate_.count("SubmitJob", {grpc::RESOURCE_EXHAUSTED, "limits.maximum_queued = 3"}, {});
  EXPECT_EQ(gate_.figures().refused,
            (std::map<std::string, std::uint64_t>{{"limits.maximum_queued", 3}}));
}

TEST(MakeStatus, GivesCodeTextAndPartsByTheReason) {
  const grpc::Status status = make_status({.reason = v1::ErrorInfo::LIMIT_REACHED,
                                           .cause = "the queue is full",
                                           .limit = "limits.maximum_queued",
                                           .permitted = "3",
                                           .remedy = "wait"});
  EXPECT_EQ(status.error_code(), grpc::RESOURCE_EXHAUSTED);
  EXPECT_EQ(status.error_message(), "the queue is full; limits.maximum_queued = 3; wait");
  const auto facts = refusal::read_details(status.error_details()).value();
  EXPECT_EQ(facts.cause, "the queue is full");
  EXPECT_EQ(facts.permitted, "3");
}

}  // namespace
}  // namespace dccast::service
