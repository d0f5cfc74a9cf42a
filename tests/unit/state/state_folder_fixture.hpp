#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "proto/values/digests.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/logs/event_log.hpp"
#include "server/jobs/store/job_store.hpp"
#include "server/state/state_folder.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::state {

/// A state folder with a store, to which jobs are added as a daemon does.
class StateFolderTest : public testing::Test {
protected:
  StateFolderTest() {
    std::filesystem::create_directories(folder_.jobs());
    store_ = std::make_unique<jobs::JobStore>(folder_.store());
  }

  static jobs::JobDescription description(const std::string& request_id) {
    jobs::JobDescription description;
    description.job.set_id(values::random_uuid());
    description.job.set_title("a casting");
    description.job.set_request_id(request_id);
    description.job.set_priority(v1::HIGH);
    description.job.set_state(v1::QUEUED);
    description.job.set_case_sha256("the sum");
    *description.job.mutable_create_time() = jobs::timestamp(1700000000123);
    description.submitted_case = std::string(3000, 's');
    description.complete_case = std::string(9000, 'c');
    return description;
  }

  /// @return its id
  std::string add_job(const std::string& request_id = "", bool with_row = true) {
    const jobs::JobDescription job = description(request_id);
    const auto folder = folder_.jobs() / job.job.id();
    jobs::create_job_folder(folder, {}, job);
    append_state(job.job.id(), v1::QUEUED);
    jobs::JobRecord record;
    record.job = job.job;
    record.sequence = 1;
    if (with_row) store_->insert(record);
    jobs::mark_accepted(folder);
    return job.job.id();
  }

  void append_state(const std::string& id, v1::JobState state) const {
    jobs::EventLog log(folder_.jobs() / id / "events.log");
    v1::Job job;
    job.set_state(state);
    if (state == v1::SUCCEEDED) job.add_artifacts()->set_name("results.h5");
    if (state == v1::FAILED) job.mutable_failure()->set_message("did not converge");
    v1::JobEvent event = jobs::state_event({.job = job}, "as the test says");
    log.append(event);
  }

  TemporaryFolder root_;
  StateFolder folder_{root_.path()};
  std::unique_ptr<jobs::JobStore> store_;
};

}  // namespace dccast::state
