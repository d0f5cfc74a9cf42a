#pragma once

#include <string>
#include <vector>

#include "server/judging/judged_run.hpp"

namespace dccast::judging {

/// Whether a casting ended because its curl had settled (time.settled). No cooling follows it.
bool has_settled(const JudgedRun& run);

/// Whether a curl has settled when its casting ends, or how fast it still moves and how much may be
/// to come. Empty of a curl that is at rest without having been asked, of one that cools down
/// afterwards, and of one that has not been followed for two seconds.
/// @param curl_m  by step [m]
std::string settling_sentence(const JudgedRun& run, const std::vector<double>& curl_m);

}  // namespace dccast::judging
