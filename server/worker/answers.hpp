#pragma once

#include <iosfwd>

namespace dccast::worker {

/// The questions the daemon does not answer in its own process. @return the exit code
/// @throws std::exception  the question cannot be read, or a result file not
int answer_check(std::istream& question, std::ostream& answer);
int answer_frame(std::istream& question, std::ostream& answer);

}  // namespace dccast::worker
