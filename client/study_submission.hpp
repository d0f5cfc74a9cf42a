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
/// and nothing else: after an interruption, for one level more, for one that was deleted.
/// @return whether all are in; if not, standard error says what is wrong with the case
/// Throws CommandFailed, Interrupted with the command to come back by.
bool submit_study(Connection& connection, const CaseUnderCheck& checked, const std::string& study,
                  int levels);

}  // namespace dccast::client
