#pragma once

#include <string>

#include "client/message_json.hpp"
#include "client/query.hpp"

namespace dccast::client::render {

/// Findings, the curl of every monitor with its uncertainty and what the run lost, a line each.
std::string answer_text(const Answer& answer);

/// Where the answer comes from and how long it took, one line.
std::string origin_text(const Answer& answer);

/// "4.86 +- 0.36 mm", of a finding's or a monitor's figure; without the second where none is known.
std::string curl_text(double curl_m, std::optional<double> uncertainty_m);

/// Everything, in metres and seconds.
Json answer_json(const Answer& answer);

}  // namespace dccast::client::render
