#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "server/jobs/store/job_store.hpp"
#include "server/state/state_folder.hpp"

namespace dccast::state {

/// The findings of a check, line by line: a word for the kind, the subject, what about it.
struct Report {
  void note(const std::string& text) { out << "note      " << text << '\n'; }
  void repaired(const std::string& text) { out << "repaired  " << text << '\n'; }
  void damage(const std::string& text) {
    out << "damage    " << text << '\n';
    ++damages;
  }

  std::ostream& out;
  int damages = 0;         ///< that are left
  int with_leftovers = 0;  ///< ended jobs, reported once at the end
  std::uintmax_t leftover_bytes = 0;
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
