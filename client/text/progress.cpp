#include "client/text/progress.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>
#include <google/protobuf/util/time_util.h>

#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"
#include "client/text/terminal_guard.hpp"

namespace dccast::client::render {
namespace {

constexpr int curve_columns = 12;               // of the renewed line
constexpr std::chrono::milliseconds pause{50};  // 20 updates per second are enough

std::string signed_mm(double metres) {
  return std::isfinite(metres) ? (metres >= 0.0 ? "+" : "") + mm(metres, 2) + " mm" : "- mm";
}

/// ", beyond validity from 166 s on"; empty for a valid run.
std::string beyond_note(const CurlHistory& history) {
  const auto first = history.first_beyond();
  if (!first) return {};
  return std::string(", ") + beyond_validity + " from " + fixed(history.time_s[*first], 0) +
         " s on";
}

/// "eta 3 s"; empty if unknown and at the end.
std::string eta_text(const Pace& pace) {
  const std::optional<double> left_s = pace.left_s();
  if (!left_s) return {};
  return *left_s < 1.0 ? "eta < 1 s" : "eta " + duration_text(*left_s);
}

std::string step_facts(const v1::StepReport& step) {
  std::string text = fmt::format(
      "step {}  t {} s  {}cast {} mm", step.step(), fixed(step.time_s(), 2),
      step.beyond_validity() ? std::string(beyond_validity) + "  " : "", mm(step.cast_length_m()));
  for (const v1::MonitorValue& monitor : step.monitors())
    text += "  " + monitor.name() + " " + signed_mm(curl_of(monitor));
  return text + "  " + std::to_string(step.iterations()) + " it";
}

}  // namespace

std::string duration_text(double seconds) {
  const long whole = std::lround(std::max(0.0, seconds));
  if (whole >= 3600) return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
  if (whole >= 60) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return seconds < 10.0 ? fmt::format("{:.1f} s", std::max(0.0, seconds))
                        : fmt::format("{} s", whole);
}

std::string step_line(const v1::StepReport& step) {
  return step_facts(step);
}

void Pace::add(const v1::StepReport& step) {
  if (!begin_ && step.time_s() >= 0.0) begin_ = step;
  last_ = step;
}

std::optional<double> Pace::left_s() const {
  constexpr double enough = 0.05;  // of what follows the hold, to know its pace
  const double left = 1.0 - last_.progress();
  if (left <= 0.0) return std::nullopt;

  const double done = begin_ ? last_.progress() - begin_->progress() : 0.0;
  if (done >= enough * (done + left)) return (last_.solver_s() - begin_->solver_s()) * left / done;
  // No remaining time can be given for a run that takes longer than expected.
  const double left_s = expected_s - last_.solver_s();
  return left_s > 0.0 ? std::optional(left_s) : std::nullopt;
}

void Progress::line(const std::string& text) {
  if (line_open_) stream_ << begin_of_line << clear_rest_of_line;
  line_open_ = false;
  stream_ << text << std::endl;
}

void Progress::renew(const std::string& text, bool force) {
  const auto now = std::chrono::steady_clock::now();
  if (!force && now - renewed_ < pause) return;
  renewed_ = now;
  stream_ << begin_of_line << clear_rest_of_line << cut_to(text, columns_now(terminal_) - 1)
          << std::flush;
  line_open_ = true;
}

void Progress::show(const v1::JobEvent& event) {
  if (event.has_resumed()) {
    history_.rewind(event.resumed().step());
    pace_.forget();
  }
  if (event.has_validity_lost()) history_.mark_beyond(event.validity_lost().time_s());
  if (!event.has_step()) return line(event_line(event));
  history_.add(event.step());
  pace_.add(event.step());

  const std::string eta = eta_text(pace_);
  if (!terminal_.interactive)
    return line(step_line(event.step()) + (eta.empty() ? "" : "  " + eta));
  std::string curve;
  if (const auto* series = history_.largest())
    curve = braille_curve(series->curl_m, curve_columns, 1).front();
  // The most important figures come first, because a narrow window cuts off the end of the line.
  renew(fmt::format("{:3.0f} % {}{}{} {}", 100.0 * event.step().progress(), eta,
                    eta.empty() ? "" : " ", curve, step_facts(event.step())),
        event.step().progress() >= 1.0);
}

void Progress::end_line() {
  if (line_open_) stream_ << std::endl;
  line_open_ = false;
}

void Progress::finish() {
  end_line();
  const auto* const series = history_.largest();
  if (!terminal_.interactive || series == nullptr || history_.time_s.size() < 2) return;

  const int columns = std::min(60, columns_now(terminal_) - 12);
  stream_ << "curl of " << series->name << ", " << fixed(history_.time_s.front(), 0) << " to "
          << fixed(history_.time_s.back(), 0) << " s" << beyond_note(history_) << '\n';
  double low = 0.0, high = 0.0;
  for (const double curl : series->curl_m) {
    low = std::min(low, curl);
    high = std::max(high, curl);
  }

  const auto lines = braille_curve(series->curl_m, columns, 5);
  for (std::size_t i = 0; i < lines.size(); ++i)
    stream_ << lines[i]
            << (i == 0                  ? " " + signed_mm(high)
                : i + 1 == lines.size() ? " " + signed_mm(low)
                                        : "")
            << '\n';
  stream_ << std::flush;
}

namespace {

/// Adds the members that belong to an event. @return its name
const char* add_particulars(const v1::JobEvent& event, Json& line) {
  switch (event.what_case()) {
    case v1::JobEvent::kStep:
      line["time_step_s"] = event.step().time_step_s();
      line["progress"] = event.step().progress();
      line["solver_s"] = event.step().solver_s();
      line["contact_length_m"] = event.step().contact_length_m();
      line["sump_depth_m"] = event.step().sump_depth_m();
      return "step";
    case v1::JobEvent::kStateChange:
      line["cause"] = event.state_change().cause();
      line["terminal"] = event.state_change().terminal();
      if (event.state_change().has_failure())
        line["failure"] = to_json(event.state_change().failure());
      return "state";
    case v1::JobEvent::kMessage:
      line["text"] = event.message().text();
      return "message";
    case v1::JobEvent::kResumed:
      line["resumed_step"] = event.resumed().step();
      line["resumed_time_s"] = event.resumed().time_s();
      return "resumed";
    case v1::JobEvent::kValidityLost:
      line["validity_loss"] = to_json(event.validity_lost());
      return "validity_lost";
    case v1::JobEvent::kFinding:
      line["finding"] = to_json(event.finding());
      return "finding";
    default:
      return "unknown";
  }
}

}  // namespace

Json WatchOutput::line(const v1::JobEvent& event) {
  if (event.has_state_change()) state_ = event.state_change().state();
  if (event.has_step()) {
    step_ = event.step();
    stepped_ = true;
    // A watch that begins during a run has not received its start.
    if (state_ == v1::JOB_STATE_UNSPECIFIED) state_ = v1::RUNNING;
  }

  const auto of_step = [&](auto value) { return stepped_ ? Json(value) : Json(); };
  Json line{{"sequence", event.sequence()},
            {"event", Json()},
            {"time", google::protobuf::util::TimeUtil::ToString(event.time())},
            {"state", v1::JobState_Name(state_)},
            {"step", of_step(step_.step())},
            {"time_s", of_step(step_.time_s())},
            {"cast_length_m", of_step(step_.cast_length_m())},
            {"iterations", of_step(step_.iterations())},
            {"beyond_validity", step_.beyond_validity()},
            {"monitors", Json::array()}};
  for (const v1::MonitorValue& monitor : step_.monitors())
    line["monitors"].push_back(to_json(monitor));

  const char* const name = add_particulars(event, line);  // moves the members of `line`
  line["event"] = name;
  return line;
}

}  // namespace dccast::client::render
