#include "proto/refusal/refusal.hpp"

#include <gtest/gtest.h>

#include "dccast/v1/service.pb.h"

namespace dccast::refusal {
namespace {

constexpr int resource_exhausted = 8;

Facts full_queue() {
  return {.reason = v1::ErrorInfo::LIMIT_REACHED,
          .cause = "the queue is full",
          .limit = "limits.maximum_queued",
          .permitted = "3",
          .remedy = "submit again later"};
}

TEST(Refusal, ItsMessageHasEveryPart) {
  EXPECT_EQ(full_queue().message(),
            "the queue is full; limits.maximum_queued = 3; submit again later");
  EXPECT_EQ((Facts{.cause = "the case has no monitor"}).message(), "the case has no monitor");
  EXPECT_EQ((Facts{.cause = "too slow", .limit = "checks.timeout", .remedy = "wait"}).message(),
            "too slow; wait");
}

TEST(Refusal, ItsPartsAreReadAsTheyWereWritten) {
  const auto read = read_details(write_details(resource_exhausted, full_queue())).value();
  EXPECT_EQ(read.reason, v1::ErrorInfo::LIMIT_REACHED);
  EXPECT_EQ(read.cause, "the queue is full");
  EXPECT_EQ(read.limit, "limits.maximum_queued");
  EXPECT_EQ(read.permitted, "3");
  EXPECT_EQ(read.remedy, "submit again later");
}

TEST(Refusal, WithoutFurtherPartsTheCauseIsTheMessage) {
  const Facts facts{.reason = v1::ErrorInfo::NOT_FOUND, .cause = "the case has no monitor"};
  EXPECT_EQ(read_details(write_details(5, facts))->cause, facts.cause);
}

/// Tools that know google.rpc read the details: the layout of its Status and ErrorInfo.
TEST(Refusal, HasTheFormOfGoogleRpc) {
  v1::StatusDetails status;
  ASSERT_TRUE(status.ParseFromString(write_details(resource_exhausted, full_queue())));
  EXPECT_EQ(status.code(), resource_exhausted);
  EXPECT_EQ(status.message(), full_queue().message());
  ASSERT_EQ(status.details_size(), 1);
  EXPECT_EQ(status.details(0).type_url(), "type.googleapis.com/google.rpc.ErrorInfo");
  v1::ErrorInfo info;
  ASSERT_TRUE(info.ParseFromString(status.details(0).value()));
  EXPECT_EQ(info.reason(), "LIMIT_REACHED");
  EXPECT_EQ(info.domain(), "dccast");
}

TEST(Refusal, CarriesTheFaultsOfACase) {
  v1::ValidateCaseResponse verdict;
  verdict.add_faults()->set_field("schedule.casting_speed");
  const std::string details = write_details(3, {.cause = "the case has 1 fault"}, &verdict);

  v1::ValidateCaseResponse read;
  ASSERT_TRUE(read_detail(details, read));
  EXPECT_EQ(read.faults(0).field(), "schedule.casting_speed");
  EXPECT_TRUE(read_details(details));

  v1::Job other;
  EXPECT_FALSE(read_detail(details, other));
}

TEST(Refusal, DetailsOfOthersAreNone) {
  EXPECT_FALSE(read_details(""));
  EXPECT_FALSE(read_details("\xff\xff\xff"));

  v1::StatusDetails status;
  ASSERT_TRUE(status.ParseFromString(write_details(resource_exhausted, full_queue())));
  v1::ErrorInfo info;
  ASSERT_TRUE(info.ParseFromString(status.details(0).value()));
  info.set_domain("proxy.example");
  status.mutable_details(0)->set_value(info.SerializeAsString());
  EXPECT_FALSE(read_details(status.SerializeAsString()));
}

TEST(LimitReached, SaysWhatItsFactsSay) {
  const LimitReached limit(
      {.cause = "the queue is full", .limit = "limits.maximum_queued", .permitted = "3"});
  EXPECT_STREQ(limit.what(), "the queue is full; limits.maximum_queued = 3");
  EXPECT_EQ(limit.facts().reason, v1::ErrorInfo::LIMIT_REACHED);
}

}  // namespace
}  // namespace dccast::refusal
