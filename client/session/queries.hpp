#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/model/answer.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/connection.hpp"

namespace dccast::client {

/// What becomes of a run, and how urgent it is.
struct QueryMode {
  bool keep = false;            ///< the run stays on the server as a job
  bool one_of_several = false;  ///< less urgent than a single query
};

/// Calls QueryButtCurl. Throws CommandFailed, Interrupted; the run ends with the call.
/// @param on_response  called with every response as it arrives
/// @return             empty if the case has faults, which are then in `checked`
std::optional<Answer> ask_query(
    Connection& connection, CaseUnderCheck& checked, const QueryMode& mode,
    const std::function<void(const v1::QueryButtCurlResponse&)>& on_response = {});

/// Names an answer to CompareRuns, under its own name.
v1::ComparedRun compared_run(const Answer& answer);
/// Names the run of a job to CompareRuns, under the beginning of its id.
v1::ComparedRun run_of_job(const std::string& job);

/// What is judged of a run.
enum class JudgedParts {
  of_steps,    ///< what its steps show
  with_frame,  ///< and its last stored frame
};

/// What the server concludes from one run that has a step. Throws CommandFailed.
/// @param line  also what its castings say of the recipe; empty: none
v1::Judgement judge_run(Connection& connection, const v1::ComparedRun& run,
                        JudgedParts parts = JudgedParts::of_steps, const std::string& line = {});

/// Queries several cases, a few at a time: the daemon runs as many as it has cores, and the others
/// wait there. Throws CommandFailed, Interrupted; the runs end with their calls.
/// @param on_wait  called when a run has to wait, with the index of its case; from any thread, by
///                 one at a time
/// @return  (case) empty for a case with faults, which are stored in the case
std::vector<std::optional<Answer>> ask_queries(
    Connection& connection, std::vector<CaseUnderCheck>& cases,
    const std::function<void(std::size_t index, const v1::QueryButtCurlResponse::Waiting&)>&
        on_wait);

/// An evenly spaced selection of the stored frames of a job, including the first and the last.
struct FrameSeries {
  int stored = 0;                      ///< frames in the results
  std::vector<v1::Frame> frames;       ///< in the order of time
  std::vector<v1::FrameField> fields;  ///< of the last frame, with their values
};

/// Selects at most `most` of `stored` frames, always including the last; numbers from 1.
std::vector<int> evenly_chosen(int stored, int most);

/// Fetches a limited number of frames one by one, to be drawn, and the fields of the last one.
/// @param last  a response with the last frame, to be drawn, and the times of all frames
FrameSeries fetch_frames(Connection& connection, const std::string& id,
                         const v1::QueryResultResponse& last, int most);

}  // namespace dccast::client
