#include "client/text/progress.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

#include "client/text/braille.hpp"
#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"
#include "client/text/terminal_guard.hpp"

namespace dccast::client {
namespace {

constexpr int curve_columns = 12;               // of the renewed line
constexpr std::chrono::milliseconds pause{50};  // 20 updates per second are enough

std::string signed_mm(double metres) {
  return std::isfinite(metres) ? (metres >= 0.0 ? "+" : "") + mm(metres, 2) + " mm" : "- mm";
}

/// ", beyond validity from 166 s on"; empty for a valid run.
std::string beyond_note(const figures::RunHistory& history) {
  const auto from_s = history.beyond_from_s();
  if (!from_s) return {};
  return std::string(", ") + beyond_validity + " from " + fixed(*from_s, 0) + " s on";
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
    text += "  " + monitor.name() + " " + signed_mm(figures::curl_of(monitor));
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
  if (const v1::MonitorValue* const judged = figures::judged_curl(event.step()))
    curve = braille_curve(history_.curl_m(judged->name()), curve_columns, 1).front();
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
  if (!terminal_.interactive || history_.steps.size() < 2) return;
  const v1::StepReport &first = history_.steps.front(), &last = history_.steps.back();
  const v1::MonitorValue* const judged = figures::judged_curl(last);
  if (judged == nullptr) return;

  const int columns = std::min(60, columns_now(terminal_) - 12);
  stream_ << "curl of " << judged->name() << ", " << fixed(first.time_s(), 0) << " to "
          << fixed(last.time_s(), 0) << " s" << beyond_note(history_) << '\n';
  const std::vector<double> curl_m = history_.curl_m(judged->name());
  double low = 0.0, high = 0.0;
  for (const double curl : curl_m) {
    low = std::min(low, curl);
    high = std::max(high, curl);
  }

  const auto lines = braille_curve(curl_m, columns, 5);
  for (std::size_t i = 0; i < lines.size(); ++i)
    stream_ << lines[i]
            << (i == 0                  ? " " + signed_mm(high)
                : i + 1 == lines.size() ? " " + signed_mm(low)
                                        : "")
            << '\n';
  stream_ << std::flush;
}

}  // namespace dccast::client
