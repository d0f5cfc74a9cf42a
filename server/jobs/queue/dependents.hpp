#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

/// Jobs that wait until others have ended. Not safe to use from several threads.
class Dependents {
public:
  /// Adds a job that waits for others, to be checked soon. @return false: it waits for none
  bool add(const v1::Job& job);
  /// Removes a job that no longer waits.
  void remove(const std::string& id);
  bool contains(const std::string& id) const { return waiting_.contains(id); }
  int size() const { return static_cast<int>(waiting_.size()); }

  /// Whether a job waits for this one.
  bool is_awaited(const std::string& id) const { return awaited_by_.contains(id); }
  /// Notes that a job has ended or was deleted: those that wait for it must be checked.
  void note_change(const std::string& id);

  /// A job that waits, with those that must end before it, and how.
  struct Dependent {
    std::string id;
    std::vector<std::string> before;
    v1::AwaitedEnd end = v1::AWAITED_SUCCESS;
  };
  bool has_next() const { return !to_check_.empty(); }
  /// Takes the next job to check: it may be able to start now, or never.
  std::optional<Dependent> take_next();
  /// Schedules another check, because this one could not be completed.
  void check_again(const std::string& id);

private:
  std::map<std::string, Dependent> waiting_;                 ///< by the job that waits
  std::map<std::string, std::set<std::string>> awaited_by_;  ///< by the job that is awaited
  std::set<std::string> to_check_;
};

}  // namespace dccast::jobs
