#pragma once

#include <functional>
#include <optional>
#include <string>

#include "client/session/studies.hpp"

/// The studies and the run of a plan on which the forecast of its casting rests
/// (docs/following.md). Labels made from the case name them, so that the same case finds them
/// again.
namespace dccast::client {

struct Preparation {
  v1::Study ensemble;
  std::optional<v1::Study> pairs;   ///< empty: not begun
  std::optional<v1::Study> levers;  ///< empty: not begun
};

/// The studies that prepare a case, the newest of each, without cancelled ones; empty: the ensemble
/// is not begun. Throws CommandFailed, Interrupted.
/// @param attachments  files of the case
std::optional<Preparation> find_preparation(
    Connection& connection, const v1::Case& plan,
    const google::protobuf::RepeatedPtrField<v1::Attachment>& attachments);

/// Makes what is missing of them: drafts over all data of the case that have a range, then some of
/// them again at engineering quality, then drafts with a lever moved while it is cast. Throws
/// CommandFailed, Interrupted.
/// @param await  waits for the end of a study
/// @return empty if the case is rejected; the faults have then been printed
std::optional<Preparation> prepare(Connection& connection, const StudyCase& base,
                                   const std::function<void(const v1::Study&)>& await);

/// The job that computes a plan as it is: the newest that is queued, runs or has succeeded, else a
/// new one. Throws CommandFailed, Interrupted.
/// @param submission  of the plan, with its files
std::string find_or_run_plan(Connection& connection, const v1::SubmitJobRequest& submission);

}  // namespace dccast::client
