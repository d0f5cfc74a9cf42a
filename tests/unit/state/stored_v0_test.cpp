#include "server/state/stored_v0.hpp"

#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"
#include "server/state/stored_v0.pb.h"
#include "server/studies/study_file.hpp"
#include "tests/unit/state/state_folder_fixture.hpp"

namespace dccast::state {
namespace {

namespace fs = std::filesystem;

std::string framed(const std::string& bytes) {
  return storage::short_records.framed(bytes);
}

class StoredV0 : public StateFolderTest {
protected:
  /// Writes the log of a job as version 1 did. Fields that both versions have stand in the new
  /// event, the others in the old one.
  void write_log(const std::string& id,
                 std::vector<std::pair<v1::JobEvent, stored_v0::JobEvent>> events) const {
    std::string bytes = jobs::former_event_log_header();
    std::int64_t sequence = 0;
    for (auto& [event, old] : events) {
      event.set_sequence(++sequence);
      bytes += framed(event.SerializeAsString() + old.SerializeAsString());
    }
    storage::replace_file(path(id), bytes);
  }

  fs::path path(const std::string& id) const { return folder_.jobs() / id / "events.log"; }

  std::vector<v1::JobEvent> events(const std::string& id) const {
    const jobs::EventLog log(path(id));
    jobs::EventLog::Cursor cursor;
    std::vector<v1::JobEvent> found;
    while (auto event = log.read(cursor)) found.push_back(std::move(*event));
    return found;
  }
};

TEST_F(StoredV0, EveryFieldOfAnEventIsFoundInItsNewPlace) {
  const std::string id = add_job();
  v1::JobEvent step, lost, ended, failed;
  stored_v0::JobEvent old_step, old_lost, old_ended, old_failed;

  v1::MonitorValue& corner = *step.mutable_step()->add_monitors();
  step.mutable_step()->set_step(1);
  step.mutable_step()->set_sump_depth_m(0.4);
  corner.set_name("corner");
  for (const double u : {0.0, 0.02}) corner.add_displacement_m(u);
  old_step.mutable_step()->set_side_heat_w_per_m(3.0);
  old_step.mutable_step()->set_weight_n(5.0);

  stored_v0::ValidityLoss& loss = *old_lost.mutable_validity_lost();
  loss.set_kind(v1::Finding::MOTION_TOO_LARGE);
  loss.set_message("it slid");
  loss.set_time_s(166.0);
  loss.set_limit(0.02);

  stored_v0::Failure& failure = *old_ended.mutable_run_ended()->mutable_failure();
  failure.set_kind(v1::Finding::CHECK_FAILED);
  failure.set_message("weight");
  failure.set_finding("weight_not_carried");
  failure.add_further_causes("STORAGE: disk full: no space");
  failure.add_further_causes("did not converge");
  ended.mutable_run_ended()->set_attempt(2);

  failed.mutable_state_change()->set_state(v1::FAILED);
  failed.mutable_state_change()->set_terminal(true);
  *old_failed.mutable_state_change()->mutable_failure() = failure;

  write_log(id, {{step, old_step}, {lost, old_lost}, {ended, old_ended}, {failed, old_failed}});
  convert_stored_v0(folder_);

  const auto found = events(id);
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(found[0].step().sump_depth_m(), 0.4);
  EXPECT_EQ(found[0].step().section().side_heat(), 3.0);
  EXPECT_EQ(found[0].step().section().weight(), 5.0);
  EXPECT_EQ(found[0].step().monitors(0).curl_m(), 0.02);

  EXPECT_EQ(found[1].validity_lost().kind(), v1::Finding::MOTION_TOO_LARGE);
  EXPECT_EQ(found[1].validity_lost().message(), "it slid");
  EXPECT_EQ(found[1].validity_lost().time_s(), 166.0);
  EXPECT_EQ(found[1].validity_lost().limit(), 0.02);

  EXPECT_EQ(found[2].run_ended().attempt(), 2);
  const v1::Finding& converted = found[2].run_ended().failure();
  EXPECT_EQ(converted.kind(), v1::Finding::CHECK_FAILED);
  EXPECT_EQ(converted.code(), "weight_not_carried");
  ASSERT_EQ(converted.further_size(), 2);
  EXPECT_EQ(converted.further(0).kind(), v1::Finding::STORAGE);
  EXPECT_EQ(converted.further(0).message(), "disk full: no space");
  EXPECT_EQ(converted.further(1).message(), "did not converge");
  EXPECT_EQ(found[3].state_change().failure().message(), "weight");
}

TEST_F(StoredV0, WhatIsOfThisVersionStaysAsItIs) {
  const std::string id = add_job();
  append_state(id, v1::FAILED);
  const std::string before = storage::read_file(path(id));
  convert_stored_v0(folder_);
  EXPECT_EQ(storage::read_file(path(id)), before);
}

TEST_F(StoredV0, ALogWithoutEventsIsEmpty) {
  const std::string id = add_job();
  write_log(id, {});
  convert_stored_v0(folder_);
  EXPECT_EQ(storage::read_file(path(id)), jobs::event_log_header());
}

TEST_F(StoredV0, RefusedRunsOfAStudyKeepTheirReason) {
  studies::StudyRecord study;
  study.id = "0d6c3a52-8f5e-4c1b-9f4e-2a7b1c3d5e6f";
  study.case_sha256 = "ab12";
  study.request.mutable_refinement()->set_levels(2);
  fs::create_directories(folder_.studies());
  studies::write_study_file(folder_.studies(), study);

  // As version 1: its number in the header, and the run with a failure of its own kind of message.
  stored_v0::Failure failure;
  failure.set_kind(v1::Finding::INVALID_CASE);
  failure.set_message("no such key");
  const fs::path file = studies::study_file(folder_.studies(), study.id);
  std::string bytes = storage::read_file(file);
  bytes.replace(8, 4, storage::little_endian(1));
  bytes += framed(storage::little_endian(1) + storage::little_endian(0) +
                  storage::little_endian(v1::FAILED) + failure.SerializeAsString());
  storage::replace_file(file, bytes);

  convert_stored_v0(folder_);
  EXPECT_EQ(studies::read_study_file(folder_.studies(), study.id).case_sha256, "ab12");
  const auto runs = studies::read_study_runs(folder_.studies(), study.id);
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs.at(1).outcome, v1::FAILED);
  EXPECT_EQ(runs.at(1).failure.kind(), v1::Finding::INVALID_CASE);
  EXPECT_EQ(runs.at(1).failure.message(), "no such key");
}

}  // namespace
}  // namespace dccast::state
