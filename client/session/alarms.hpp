#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <tuple>

#include "client/session/connection.hpp"

namespace dccast::client {

/// Whom the alarms of a casting reach, and its forecast. A handler may be empty.
struct AlarmHandlers {
  std::function<void(const v1::Forecast&)> forecast{};  ///< each new one
  std::function<void(const v1::ForecastWarning&)> warning{};
  std::function<void(const v1::Finding&)> finding{};        ///< beyond notes
  std::function<void(const v1::ForecastWarning&)> lever{};  ///< off its plan (CastingNow.alarms)
};

/// Asks what is wrong with a casting that a job follows, and tells each thing once.
class AlarmWatch {
public:
  /// @param id  of the job
  AlarmWatch(std::string id, AlarmHandlers handlers)
      : id_(std::move(id)), handlers_(std::move(handlers)) {}

  /// Asks once. Does nothing while the server is away, and for a job without a forecast. Throws
  /// Interrupted.
  void look(Connection& connection);

private:
  void look_at_forecast(Connection& connection);
  void look_at_job(Connection& connection);
  /// Passes on those that were not passed on before.
  void tell(const google::protobuf::RepeatedPtrField<v1::ForecastWarning>& warnings,
            const std::function<void(const v1::ForecastWarning&)>& handler);

  std::string id_;
  AlarmHandlers handlers_;

  /// What was told already.
  std::optional<double> last_forecast_s_;
  std::set<std::tuple<double, std::string, std::string>> warnings_;  ///< time, monitor, text
  std::set<std::string> findings_;                                   ///< codes
};

}  // namespace dccast::client
