#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/verification/program/run_request.hpp"
#include "tests/verification/program/table.hpp"

namespace dccast::verification {

enum class Relation {
  at_most,   ///< measured <= bound
  within,    ///< |measured / bound - 1| <= tolerance
  fails_at,  ///< the run fails, and at time bound
};

/// A figure that must be reached, and how it is measured.
struct Claim {
  std::string what;
  RunRequest request;
  std::string key;  ///< of the figures; empty for fails_at
  Relation relation = Relation::at_most;
  double bound = 0.0;
  double tolerance = 0.0;  ///< relative, of `within`
  bool nightly = false;    ///< too long for every day
};

struct Verdict {
  const Claim* claim = nullptr;
  double measured = 0.0;  ///< not a number when the run gave no such figure
  bool passed = false;
  std::string note;  ///< when and why a run failed
};

/// Every figure that is claimed.
const std::vector<Claim>& claims();

/// Runs requests, each once however many claims ask for it.
class Runs {
public:
  const Result& of(const RunRequest& request);

private:
  std::map<std::string, Result> results_;
};

Verdict judge(const Claim& claim, Runs& runs);
/// @param measured  the figure the claim names
Verdict judge_figure(const Claim& claim, double measured);
/// "figure: measured, to reach bound", for people.
std::string miss_of(const Verdict& verdict);
/// Claims about a run's errors that hold for its request, whatever the algorithm.
std::vector<const Claim*> claims_about(const RunRequest& request);

/// A figure by its key; not a number when there is none.
double figure(const Figures& figures, const std::string& key);

/// The verdicts as a table: figure, command, bound, ours, verdict.
Table table_of(const std::vector<Verdict>& verdicts);

}  // namespace dccast::verification
