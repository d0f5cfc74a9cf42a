#pragma once

#include <string>

#include "client/case_faults.hpp"
#include "client/connection.hpp"

namespace dccast::client {

/// Submits a case with cells and steps divided by 1, 2, 4, ... as jobs of one study, the coarsest
/// first, with low priority. All levels are checked before the first is submitted: a study that
/// would end without its finest level is refused while it has cost nothing.
///
/// The request ids follow from the study, so that doing this again adds the levels that are missing
/// and nothing else: after an interruption, for one level more, for one that was deleted. Levels
/// that were lost are replaced as by repair_study().
/// @return whether all are in; if not, standard error says what is wrong with the case
/// Throws CommandFailed, Interrupted with the command to come back by.
bool submit_study(Connection& connection, const CaseUnderCheck& checked, const std::string& study,
                  int levels);

/// Submits the levels of a study again that were cancelled or failed for a cause that is not the
/// case's own (a lost worker, a full disk), as new attempts, and says so on standard error. The
/// case is taken from the job that was lost. Throws CommandFailed, Interrupted.
void repair_study(Connection& connection, const std::string& study);

}  // namespace dccast::client
