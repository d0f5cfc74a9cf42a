#include "client/session/kept_clock.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>

#include "client/session/private_file.hpp"
#include "client/session/unsent_readings.hpp"

namespace dccast::client {

namespace fs = std::filesystem;

fs::path kept_clock_file(const std::string& job) {
  fs::path file = unsent_readings_file(job);
  if (!file.empty()) file += ".clock";
  return file;
}

// One line for the first line of the source, then one for each jump: stamp, hash of the line,
// offset.

SourceClock::History read_kept_clock(const fs::path& file) {
  std::ifstream text(file);
  SourceClock::History kept;
  text >> kept.first.stamp_s >> kept.first.content;
  for (SourceClock::History::Jump jump;
       text >> jump.at.stamp_s >> jump.at.content >> jump.offset_s;)
    kept.jumps.push_back(jump);
  return kept;
}

std::string keep_clock(const fs::path& file, const SourceClock::History& history) {
  if (file.empty()) return "neither XDG_STATE_HOME nor HOME is set";
  std::string text = fmt::format("{} {}\n", history.first.stamp_s, history.first.content);
  for (const auto& [at, offset_s] : history.jumps)
    fmt::format_to(std::back_inserter(text), "{} {} {}\n", at.stamp_s, at.content, offset_s);

  const std::string fault = write_private_file(file, text);
  return fault.empty() ? fault : fmt::format("{} cannot be written: {}", file.string(), fault);
}

}  // namespace dccast::client
