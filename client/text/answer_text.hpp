#pragma once

#include <string>

#include "client/model/answer.hpp"
#include "client/model/json.hpp"

namespace dccast::client {

/// Changes, findings, a loss of validity and a failure, one per line.
std::string answer_text(const Answer& answer);

/// What a query waits for and how long, in one line: "waiting for 2 queries, about 40 s".
std::string waiting_text(const v1::QueryButtCurlResponse::Waiting& waiting);

/// Origin of the answer and the time it took, in one line.
std::string origin_text(const Answer& answer);

/// The complete answer, in metres and seconds.
Json answer_json(const Answer& answer);

}  // namespace dccast::client
