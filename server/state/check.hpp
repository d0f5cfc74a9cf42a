#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "server/jobs/job_store.hpp"
#include "server/state/state_folder.hpp"

namespace dccast::state {

/// The findings of a check, line by line: a word for the kind, the subject, what about it.
class Report {
public:
  explicit Report(std::ostream& out) : out_(out) {}
  void note(const std::string& text) { out_ << "note      " << text << '\n'; }
  void repaired(const std::string& text) { out_ << "repaired  " << text << '\n'; }
  void damage(const std::string& text) {
    out_ << "damage    " << text << '\n';
    ++damages_;
  }
  int damages() const { return damages_; }

  // Sums over all jobs, reported once at the end.
  int with_leftovers = 0;
  std::uintmax_t leftover_bytes = 0;

private:
  std::ostream& out_;
  int damages_ = 0;  ///< that are left
};

struct CheckOptions {
  bool repair = false;               ///< put right what can be; nothing but leftovers is deleted
  bool deep = false;                 ///< also hold results against their SHA-256
  std::vector<std::string> adopt{};  ///< ids of quarantined jobs to take back
  bool index_only = false;           ///< only the store is put right; workers may run
};

/// Inspects a state folder that no daemon uses and reports what is wrong with it; with `repair`
/// puts it right. docs/operations.md describes each line. @return damages that are left
/// @throws std::runtime_error  there is no such folder, a daemon uses it, or it cannot be read
int check(const StateFolder& folder, const CheckOptions& options, std::ostream& out);

/// The part of check() about one job with a row.
void check_job(const StateFolder& folder, jobs::JobStore& store, const std::string& id,
               const CheckOptions& options, Report& report);

}  // namespace dccast::state
