#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>

#include "core/casting/casting_run.hpp"
#include "server/jobs/logs/readings_log.hpp"
#include "server/levers/lever_watch.hpp"

namespace dccast::worker {

/// Reads the levers of a casting from the record in the folder of its job, to which the daemon adds
/// while the run goes on.
class FollowedLevers final : public casting::LeverFeed {
public:
  /// @param plan   complete
  /// @param order  what the run is asked to do
  /// @throws std::system_error, jobs::DamagedReadings  the record cannot be read
  FollowedLevers(const std::filesystem::path& job_folder, const v1::Case& plan,
                 std::function<casting::Order()> order)
      : record_(job_folder), watch_(plan), order_(std::move(order)) {}

  /// @throws std::system_error, jobs::DamagedReadings  the record cannot be read
  Arrived wait_until(double time) override;

  /// What is to be done first about a finding, since a lever is off its plan; empty: none is.
  std::string remedy_at(double time_s) const { return watch_.remedy_at(time_s); }

private:
  jobs::ReadingsReader record_;
  levers::LeverWatch watch_;
  std::function<casting::Order()> order_;
  bool closed_ = false;
};

}  // namespace dccast::worker
