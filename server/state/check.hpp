#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "server/jobs/store/job_store.hpp"
#include "server/state/state_folder.hpp"

namespace dccast::state {

/// Report of a check, line by line: the kind of the finding, its subject, its description.
struct Report {
  void note(const std::string& text) { out << "note      " << text << '\n'; }
  void repaired(const std::string& text) { out << "repaired  " << text << '\n'; }
  void damage(const std::string& text) {
    out << "damage    " << text << '\n';
    ++damages;
  }

  std::ostream& out;
  int damages = 0;         ///< number of damages that remain
  int with_leftovers = 0;  ///< ended jobs with leftover files, reported once at the end
  std::uintmax_t leftover_bytes = 0;
};

struct CheckOptions {
  bool repair = false;               ///< repair what can be repaired; only leftovers are deleted
  bool deep = false;                 ///< also compare results with their SHA-256
  std::vector<std::string> adopt{};  ///< ids of quarantined jobs to restore
  bool index_only = false;           ///< repair the store only; workers may be running
};

/// Inspects a state folder that no daemon uses, and reports its faults; with `repair` it repairs
/// them. docs/operations.md describes each line. @return number of damages that remain
/// @throws std::runtime_error  there is no such folder, a daemon uses it, or it cannot be read
int check(const StateFolder& folder, const CheckOptions& options, std::ostream& out);

/// The part of check() about one job with a row.
void check_job(const StateFolder& folder, jobs::JobStore& store, const std::string& id,
               const CheckOptions& options, Report& report);

}  // namespace dccast::state
