#pragma once

#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "client/session/connection.hpp"
#include "client/session/jobs.hpp"
#include "dccast/v1/study.pb.h"

namespace dccast::client {

/// The case of a study as given on the command line.
struct StudyCase {
  /// Path of a case file; "-" is standard input.
  std::string file;
  std::vector<std::string> set;  ///< KEY=VALUE
  std::vector<std::string> labels;
  /// What named the keys of the plan, for faults in them, e.g. "--grid"; empty: the program.
  std::string plan_origin{};
};

/// Reads the case and creates a study with the plan that `add_plan` adds to the request. Throws
/// CommandFailed, Interrupted.
/// @return empty if case or plan are rejected; the faults have then been printed
std::optional<v1::Study> create_study(Connection& connection, const StudyCase& base,
                                      const std::function<void(v1::CreateStudyRequest&)>& add_plan);

/// Passes a study to `on_study` whenever it has changed, until it has ended; returns it. A stream
/// that ends before is reconnected as in follow_job. Throws CommandFailed, Interrupted.
v1::Study follow_study(Connection& connection, const std::string& id,
                       const std::function<void(const v1::Study&)>& on_study,
                       std::ostream& messages, const RetryPolicy& policy = {});

/// Passes the studies that a request selects to `take`, newest first, until it returns false.
/// Throws CommandFailed.
/// @param request  its page_size is that of each call
void read_studies(Connection& connection, v1::ListStudiesRequest request,
                  const std::function<bool(const v1::Study&)>& take);

/// The newest of these studies, at most `limit`. Throws CommandFailed.
std::vector<v1::Study> list_studies(Connection& connection, v1::ListStudiesRequest request,
                                    int limit);

/// The id of the study that a user means: a complete id, a unique beginning of one, or `last` for
/// the newest study of this user. Throws CommandFailed: no such study, or several.
std::string resolve_study(Connection& connection, const std::string& text);

/// Help text of a STUDY argument.
inline constexpr const char* study_help = "Study id, the beginning of one, or last";

/// Exit code for the answer of a study that has ended, or of one under way so far.
/// @param has_answer  the judgement has what was asked for
ExitCode exit_code_of(const v1::StudyJudgement& answer, bool has_answer);

/// The jobs of a study, oldest first; empty for an unknown study.
std::vector<v1::Job> jobs_of_study(Connection& connection, const std::string& id);

/// Results of a study so far. Throws CommandFailed.
v1::StudyResult evaluate_study(Connection& connection, const std::string& id);

/// A question about the results of a study.
struct StudyQuestion {
  std::string id{};
  std::string monitor{};  ///< whose curl is judged; empty: output.curl, or the largest
  bool curves = false;    ///< with the curl of every run against time
  std::string line{};     ///< whose castings condition an uncertainty; empty: none
  bool assume_sound = false;
};
/// What the server concludes from a study so far, with the figures. Throws CommandFailed.
v1::StudyJudgement judge_study(Connection& connection, const StudyQuestion& question);

/// The case of a user's file with what a study found, as a file that the server writes. Throws
/// CommandFailed, also for faults of the case, which have then been printed.
/// @param question  names the study, of a calibration with its castings
/// @return empty where nothing was found
std::string found_case(Connection& connection, v1::JudgeStudyRequest question,
                       const StudyCase& base);

/// As evaluate_study(); an empty result where the server has no such study.
v1::StudyResult find_study(Connection& connection, const std::string& id);

/// The results so far of the refinement study to which a job belongs; empty if it belongs to none.
v1::StudyResult refinement_of(Connection& connection, const v1::Job& job);

}  // namespace dccast::client
