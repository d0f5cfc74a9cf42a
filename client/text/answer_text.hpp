#pragma once

#include <string>

#include "client/model/json.hpp"
#include "client/session/queries.hpp"

namespace dccast::client::render {

/// Findings, the curl of every monitor with its uncertainty, and a loss of validity, one per line.
std::string answer_text(const Answer& answer);

/// Origin of the answer and the time it took, in one line.
std::string origin_text(const Answer& answer);

/// "4.86 +- 0.36 mm"; without an uncertainty only the first number. @param curl_m  [m]
/// @param uncertainty_m  [m]
std::string curl_text(double curl_m, std::optional<double> uncertainty_m);

/// The complete answer, in metres and seconds.
Json answer_json(const Answer& answer);

}  // namespace dccast::client::render
