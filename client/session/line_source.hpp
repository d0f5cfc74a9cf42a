#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "client/session/mqtt.hpp"

namespace dccast::client {

/// Where lines come from.
class LineSource {
public:
  virtual ~LineSource() = default;

  /// The complete lines that are there, at least one; waits for it. Empty: there are no more, or
  /// the stop was requested. Of a line that is too long to be read the begin is enough.
  virtual std::vector<std::string> next(const std::stop_token& stop) = 0;
};

/// What happens at the end of a file.
enum class FileEnd {
  ends_source,  ///< there are no further lines
  grows         ///< they are awaited
};

/// Lines of standard input or of a file. A file that grows is followed by its name: where another
/// file gets it, or it is cut, reading goes on at the begin of the new one.
/// @param path    "-" for standard input
/// @param remark  receives that the file is a new one, and that no line comes for 10 s; may be
/// empty Throws CommandFailed: the file cannot be read.
std::unique_ptr<LineSource> lines_of_file(const std::string& path, FileEnd end, Remark remark = {});

/// Lines of the messages that a topic receives from now on; there are always more.
/// @param remark  receives whether the broker is there, and that no line comes for 10 s
/// Throws CommandFailed: the broker does not answer, or refuses.
std::unique_ptr<LineSource> lines_of_topic(const Topic& topic, const BrokerLogin& login,
                                           Remark remark);

}  // namespace dccast::client
