#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "dccast/v1/judgement.pb.h"
#include "dccast/v1/study.pb.h"
#include "proto/case_file/study_keys.hpp"
#include "server/judging/judged_run.hpp"

namespace dccast::judging {

/// A study with what its judgement rests on.
struct StudyToJudge {
  v1::StudyResult result;  ///< as evaluated; of an uncertainty study with the spread of the monitor
  int monitor = 0;         ///< index of the monitor whose curl is judged
  /// Error of a small difference between two runs, relative to the curl
  /// (case_file::paired_error); empty: not measured for such a case.
  std::optional<double> difference_error{};
  std::vector<JudgedRun> runs{};  ///< (run) of a remedy study, else empty
};

using case_file::monitor_of;

/// Whether figures rest on a run: it succeeded and stayed valid.
bool is_valid(const v1::StudyRun& run);

/// The first valid run; of a sensitivity study that is the case itself. Null: there is none.
const v1::StudyRun* first_valid_run(const v1::StudyResult& result);

/// The band of a monitor's curls, that of the first valid run; empty: not known.
std::optional<v1::RelativeError> study_study_mesh_error(const v1::StudyResult& result,
                                                        const std::string& monitor);

/// The answer of a study so far: sentences, and the tables and charts that they rest on. A sweep
/// without a purpose has charts and the table of its runs alone; so has a calibration that was not
/// evaluated.
v1::Judgement judge_study(const StudyToJudge& study);

/// What a study found does not fit the case that it is to be written into.
class UnfitCase : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// A case file with what a study found: the values of a calibration, their ranges in [uncertainty]
/// and where they are from, or the chosen recipe. Empty where nothing was found.
/// @param submitted  as in its file
/// @param complete   the case of the study
/// @throws UnfitCase
std::string found_case(const v1::StudyResult& result, const v1::Case& submitted,
                       const v1::Case& complete);

}  // namespace dccast::judging
