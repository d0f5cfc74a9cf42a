#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/session/case_faults.hpp"
#include "fake_service.hpp"

namespace dccast::client {
namespace {

v1::Fault fault(const std::string& field, const std::string& message) {
  v1::Fault fault;
  fault.set_field(field);
  fault.set_message(message);
  return fault;
}

TEST(MergeFaults, KeepsBothAndDropsWhatFollowsFromALocalOne) {
  const auto merged = merge_faults(
      {fault("section.half_width", "no unit"), fault("schedule.water_flow[1]", "kg")},
      {fault("section.half_width", "required key is missing"),
       fault("schedule.water_flow", "absent"), fault("monitor[0]", "outside the slab")});
  ASSERT_EQ(merged.size(), 3u);
  EXPECT_EQ(merged[2].field(), "monitor[0]");
}

TEST(MergeFaults, ALikeNameIsNotTheSameKey) {
  EXPECT_EQ(merge_faults({fault("time.end", "a")}, {fault("time.ending", "b")}).size(), 2u);
}

TEST(FaultsOf, ReadsTheDetailsOfAStatusAndSurvivesNonsense) {
  v1::ValidateCaseResponse response;
  *response.add_faults() = fault("a", "b");
  EXPECT_EQ(faults_of(refusal_with(response)).size(), 1u);
  EXPECT_TRUE(faults_of({grpc::StatusCode::INVALID_ARGUMENT, "", "\xff\xff\xff"}).empty());
  EXPECT_TRUE(faults_of(grpc::Status::OK).empty());
}

}  // namespace
}  // namespace dccast::client
