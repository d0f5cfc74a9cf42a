#pragma once

#include <filesystem>
#include <string>

#include "client/session/source_clock.hpp"

namespace dccast::client {

/// Where the jumps of the clock are kept whose readings a job follows, beside its unsent readings:
/// $XDG_STATE_HOME/dccast/readings/JOB.clock; empty: there is no home.
std::filesystem::path kept_clock_file(const std::string& job);

/// What an earlier program has kept; nothing if it has not, or the file cannot be read.
SourceClock::History read_kept_clock(const std::filesystem::path& file);

/// Keeps the jumps (mode 0600). @return why they cannot be kept; empty: they are
std::string keep_clock(const std::filesystem::path& file, const SourceClock::History& history);

}  // namespace dccast::client
