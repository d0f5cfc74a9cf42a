#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "dccast/v1/job.pb.h"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/queue/lane.hpp"

namespace dccast::jobs {

/// Jobs that wait for their `begin_time`. Not safe to use from several threads.
class Begins {
public:
  struct Waiting {
    v1::Job job;
    Lane lane = Lane::job;
  };

  /// Adds a job whose time has not come. Times are in milliseconds since 1970.
  /// @return false: it has none, or it has come
  bool add(const v1::Job& job, Lane lane, std::int64_t now_ms) {
    const std::int64_t begin_ms = milliseconds(job.begin_time());
    if (!job.has_begin_time() || begin_ms <= now_ms) return false;
    waiting_[job.id()] = {job, lane};
    by_time_.emplace(begin_ms, job.id());
    return true;
  }

  /// Removes a job that no longer waits. @return it, if it was there
  std::optional<Waiting> remove(const std::string& id) {
    const auto found = waiting_.find(id);
    if (found == waiting_.end()) return std::nullopt;
    Waiting removed = std::move(found->second);
    by_time_.erase({milliseconds(removed.job.begin_time()), id});
    waiting_.erase(found);
    return removed;
  }

  /// Takes the next job whose time has come.
  std::optional<Waiting> take_begun(std::int64_t now_ms) {
    if (by_time_.empty() || by_time_.begin()->first > now_ms) return std::nullopt;
    return remove(std::string(by_time_.begin()->second));
  }

  bool contains(const std::string& id) const { return waiting_.contains(id); }
  int size() const { return static_cast<int>(waiting_.size()); }

private:
  std::map<std::string, Waiting> waiting_;  ///< by id
  std::set<std::pair<std::int64_t, std::string>> by_time_;
};

}  // namespace dccast::jobs
