#include "client/commands/follow_alarms.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>

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

/// A connection that the copies of a handler share; null without a topic.
std::shared_ptr<MqttConnection> publisher_of(const std::string& topic, const std::string& broker) {
  if (topic.empty()) return nullptr;
  const auto remark = [topic](const std::string& text) {
    std::cerr << topic << ": " << text << std::endl;
  };
  return std::make_shared<MqttConnection>(parse_topic(topic), read_broker_login(broker),
                                          MqttConnection::Handlers{.remark = remark});
}

/// Passes alarms to the command and the topic that the options name.
Notify notifier_of(const AlarmOptions& options, const std::string& broker, const std::string& job) {
  const auto connection = publisher_of(options.topic, broker);
  return [=, command = options.command](const std::string& text, Json facts) {
    if (!command.empty()) run_user_command(command, {{"DCCAST_JOB", job}, {"DCCAST_ALARM", text}});
    if (!connection) return;
    facts["job"] = job;
    facts["alarm"] = text;
    connection->publish(facts.dump());
  };
}

/// A forecast as plain values for the tags of a control system [mm], to hundredths.
Json values_of(const v1::Forecast& forecast) {
  Json values{{"time_s", forecast.time_s()}};
  for (const v1::ForecastCurl& curl : forecast.curls()) {
    const double then_s = soon_s(forecast, curl), end_s = *curl.time_s().rbegin();
    Json& of_gauge = values[curl.monitor()] = {{"soon_s", then_s}, {"end_s", end_s}};
    for (const auto& [name, at_s] : {std::pair("soon", then_s), {"end", end_s}}) {
      const CurlToCome there = curl_to_come(curl, at_s);
      const auto add = [&](const char* what, double value_mm) {
        of_gauge[fmt::format("{}{}_mm", name, what)] = std::round(100.0 * value_mm) / 100.0;
      };
      add("", there.curl_mm);
      add("_lower", there.lower_mm);
      add("_upper", there.upper_mm);
    }
  }
  return values;
}

}  // namespace

AlarmHandlers alarm_handlers(const AlarmOptions& options, const std::string& broker,
                             const std::string& job) {
  const Notify notify = notifier_of(options, broker, job);
  AlarmHandlers handlers;

  handlers.forecast = [job, publisher = publisher_of(options.forecasts, broker),
                       last_s = std::optional<double>()](const v1::Forecast& forecast) mutable {
    if (publisher) {
      Json values = values_of(forecast);
      values["job"] = job;
      publisher->publish(values.dump());
    }
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
  command.option(
      "--forecasts", options.forecasts,
      "Publish each forecast as JSON on a topic: the curls to come, for tags and displays",
      {.placeholder = "TOPIC"});
}

}  // namespace dccast::client
