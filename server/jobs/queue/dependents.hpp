#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

/// Jobs that wait until others have succeeded. Not safe to use from several threads.
class Dependents {
public:
  /// Takes a job that waits for others, and has it looked at. @return false: it waits for none
  bool add(const v1::Job& job);
  /// Forgets a job that waits no more.
  void remove(const std::string& id);
  bool contains(const std::string& id) const { return before_.contains(id); }
  int size() const { return static_cast<int>(before_.size()); }

  /// Whether a job waits for this one.
  bool is_awaited(const std::string& id) const { return awaited_by_.contains(id); }
  /// A job has ended or was deleted: those that wait for it are to be looked at.
  void note_change_of(const std::string& id);

  struct Dependent {
    std::string id;
    std::vector<std::string> before;  ///< the jobs that have to succeed first
  };
  bool has_next() const { return !to_look_at_.empty(); }
  /// The next one to be looked at, which is removed from those: it may start now, or never will.
  std::optional<Dependent> take_next();
  /// It could not be decided now.
  void look_again_at(const std::string& id);

private:
  std::map<std::string, std::vector<std::string>> before_;   ///< by the job that waits
  std::map<std::string, std::set<std::string>> awaited_by_;  ///< the same from the other side
  std::set<std::string> to_look_at_;
};

}  // namespace dccast::jobs
