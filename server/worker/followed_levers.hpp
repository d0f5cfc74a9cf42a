#pragma once

#include <filesystem>
#include <functional>

#include "core/casting/casting_run.hpp"
#include "server/jobs/logs/readings_log.hpp"

namespace dccast::worker {

/// Reads the levers of a casting from the record in the folder of its job, to which the daemon adds
/// while the run goes on.
class FollowedLevers final : public casting::LeverFeed {
public:
  /// @param order  what the run is asked to do
  /// @throws std::system_error, jobs::DamagedReadings  the record cannot be read
  FollowedLevers(const std::filesystem::path& job_folder, std::function<casting::Order()> order)
      : record_(job_folder), order_(std::move(order)) {}

  /// @throws std::system_error, jobs::DamagedReadings  the record cannot be read
  Arrived wait_until(double time) override;

private:
  jobs::ReadingsReader record_;
  std::function<casting::Order()> order_;
  bool closed_ = false;
};

}  // namespace dccast::worker
