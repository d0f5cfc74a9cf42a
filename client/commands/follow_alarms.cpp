#include "client/commands/follow_alarms.hpp"

#include <fmt/format.h>

#include <functional>
#include <iostream>
#include <memory>
#include <optional>

#include "client/model/json.hpp"
#include "client/session/mqtt.hpp"
#include "client/session/user_command.hpp"
#include "client/text/findings.hpp"
#include "client/text/forecast_text.hpp"
#include "client/text/terminal.hpp"

namespace dccast::client {

namespace {

/// How often the forecast is written [s of the casting].
constexpr double between_forecasts_s = 30.0;

/// Passes an alarm on. @param text  for people @param facts  the same for programs
using Notify = std::function<void(const std::string& text, Json facts)>;

/// Passes alarms to the command and the topic that the options name.
Notify notifier_of(const AlarmOptions& options, const std::string& broker, const std::string& job) {
  std::shared_ptr<MqttConnection> connection;
  // The copies of the function share one connection to the broker.
  if (!options.topic.empty()) {
    const auto remark = [](const std::string& text) {
      std::cerr << "alarms: " << text << std::endl;
    };
    connection =
        std::make_shared<MqttConnection>(parse_topic(options.topic), read_broker_login(broker),
                                         MqttConnection::Handlers{.remark = remark});
  }

  return [=, command = options.command](const std::string& text, Json facts) {
    if (!command.empty()) run_user_command(command, {{"DCCAST_JOB", job}, {"DCCAST_ALARM", text}});
    if (!connection) return;
    facts["job"] = job;
    facts["alarm"] = text;
    connection->publish(facts.dump());
  };
}

}  // namespace

AlarmHandlers alarm_handlers(const AlarmOptions& options, const std::string& broker,
                             const std::string& job) {
  const Notify notify = notifier_of(options, broker, job);
  AlarmHandlers handlers;

  handlers.forecast = [last_s = std::optional<double>()](const v1::Forecast& forecast) mutable {
    if (last_s && forecast.time_s() < *last_s + between_forecasts_s) return;
    last_s = forecast.time_s();
    std::cerr << forecast_line(forecast) << std::endl;
  };

  handlers.warning = [notify](const v1::ForecastWarning& warning) {
    const std::string text =
        fmt::format("warning at {:.0f} s, {}", warning.time_s(), warning_text(warning));
    std::cerr << text << std::endl;
    notify(text, Json{{"warning", to_json(warning)}});
  };

  // What the plant can mend at once stands out.
  handlers.lever = [notify](const v1::ForecastWarning& alarm) {
    const std::string text =
        fmt::format("ALARM at {:.0f} s, {}", alarm.time_s(), warning_text(alarm));
    std::cerr << red(text, terminal_of(2)) << std::endl;
    notify(text, Json{{"lever", to_json(alarm)}});
  };

  // The watch of the job has printed it already.
  handlers.finding = [notify](const v1::Finding& finding) {
    notify(finding_line(finding), Json{{"finding", to_json(finding)}});
  };
  return handlers;
}

void add_alarm_options(const Command& command, AlarmOptions& options) {
  command.option(
      "--notify", options.command,
      "Run this in a shell for each warning of the forecast and each finding beyond notes, "
      "with DCCAST_JOB and DCCAST_ALARM in its environment",
      {.placeholder = "COMMAND"});
  command.option("--alarms", options.topic,
                 "Publish these as JSON on a topic, as mqtt://HOST/TOPIC",
                 {.placeholder = "TOPIC"});
}

}  // namespace dccast::client
