#pragma once

#include <string>

#include "client/cli/options.hpp"
#include "client/session/alarms.hpp"

namespace dccast::client {

/// Where alarms and forecasts of a followed casting go, besides standard error.
struct AlarmOptions {
  std::string command;    ///< of --notify
  std::string topic;      ///< of --alarms
  std::string forecasts;  ///< topic of --forecasts
};

void add_alarm_options(const Command& command, AlarmOptions& options);

/// Handlers that write to standard error, run the command and publish on the topics. Throws
/// CommandFailed: the broker does not answer, or refuses.
/// @param broker  file with the login, or empty
/// @param job     that follows the casting
AlarmHandlers alarm_handlers(const AlarmOptions& options, const std::string& broker,
                             const std::string& job);

}  // namespace dccast::client
