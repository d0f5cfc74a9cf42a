#include "client/text/progress.hpp"

#include <google/protobuf/util/time_util.h>

#include <cmath>
#include <cstdio>

#include "client/text/braille.hpp"
#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

constexpr int curve_columns = 12;               // of the renewed line
constexpr std::chrono::milliseconds pause{50};  // 20 updates per second are enough

std::string signed_mm(double metres) {
  return std::isfinite(metres) ? (metres >= 0.0 ? "+" : "") + fixed(1e3 * metres, 2) + " mm"
                               : "- mm";
}

/// ", beyond validity from 166 s on"; nothing for a run that is valid.
std::string beyond_note(const CurlHistory& history) {
  const auto first = history.first_beyond();
  if (!first) return {};
  return std::string(", ") + beyond_validity + " from " + fixed(history.time_s[*first], 0) +
         " s on";
}

std::string eta_text(const v1::StepReport& step) {
  const double rest = remaining_s(step);
  return rest >= 0.0 && step.progress() < 1.0 ? "eta " + duration_text(rest) : "";
}

std::string step_facts(const v1::StepReport& step) {
  std::string text = "step " + std::to_string(step.step()) + "  t " + fixed(step.time_s(), 2) +
                     " s  " + (step.beyond_validity() ? std::string(beyond_validity) + "  " : "") +
                     "cast " + fixed(1e3 * step.cast_length_m(), 1) + " mm";
  for (const v1::MonitorValue& monitor : step.monitors())
    text += "  " + monitor.name() + " " + signed_mm(curl_of(monitor));
  return text + "  " + std::to_string(step.iterations()) + " it";
}

}  // namespace

double remaining_s(const v1::StepReport& step) {
  if (!(step.progress() > 0.0)) return -1.0;
  return step.solver_s() * (1.0 - step.progress()) / step.progress();
}

std::string duration_text(double seconds) {
  char text[48];
  const long whole = std::lround(std::max(0.0, seconds));
  if (whole >= 3600)
    std::snprintf(text, sizeof text, "%ld h %02ld min", whole / 3600, whole / 60 % 60);
  else if (whole >= 60)
    std::snprintf(text, sizeof text, "%ld min %02ld s", whole / 60, whole % 60);
  else if (seconds < 10.0)
    std::snprintf(text, sizeof text, "%.1f s", std::max(0.0, seconds));
  else
    std::snprintf(text, sizeof text, "%ld s", whole);
  return text;
}

std::string step_line(const v1::StepReport& step) {
  const std::string eta = eta_text(step);
  return step_facts(step) + (eta.empty() ? "" : "  " + eta);
}

void Progress::line(const std::string& text) {
  if (line_open_) stream_ << "\r\033[K";
  line_open_ = false;
  stream_ << text << std::endl;
}

void Progress::renew(const std::string& text, bool force) {
  const auto now = std::chrono::steady_clock::now();
  if (!force && now - renewed_ < pause) return;
  renewed_ = now;
  stream_ << "\r\033[K" << cut_to(text, columns_now(terminal_) - 1) << std::flush;
  line_open_ = true;
}

void Progress::show(const v1::JobEvent& event) {
  if (event.has_resumed()) history_.rewind(event.resumed().step());
  if (event.has_validity_lost()) history_.mark_beyond(event.validity_lost().time_s());
  if (!event.has_step()) return line(event_line(event));
  history_.add(event.step());
  if (!terminal_.interactive) return line(step_line(event.step()));
  std::string curve;
  if (const auto* series = history_.largest())
    curve = braille_curve(series->curl_m, curve_columns, 1).front();
  char percent[16];
  std::snprintf(percent, sizeof percent, "%3.0f %% ", 100.0 * event.step().progress());
  // The most important data come first: the end of the line is cut off in a narrow window.
  const std::string eta = eta_text(event.step());
  renew(percent + eta + (eta.empty() ? "" : " ") + curve + " " + step_facts(event.step()),
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

const char* event_name(const v1::JobEvent& event) {
  switch (event.what_case()) {
    case v1::JobEvent::kStateChange:
      return "state";
    case v1::JobEvent::kStep:
      return "step";
    case v1::JobEvent::kMessage:
      return "message";
    case v1::JobEvent::kResumed:
      return "resumed";
    case v1::JobEvent::kValidityLost:
      return "validity_lost";
    case v1::JobEvent::kFinding:
      return "finding";
    default:
      return "unknown";
  }
}

void add_particulars(const v1::JobEvent& event, Json& line) {
  if (event.has_step()) {
    line["time_step_s"] = event.step().time_step_s();
    line["progress"] = event.step().progress();
    line["solver_s"] = event.step().solver_s();
    line["contact_length_m"] = event.step().contact_length_m();
    line["sump_depth_m"] = event.step().sump_depth_m();
  } else if (event.has_state_change()) {
    line["cause"] = event.state_change().cause();
    line["terminal"] = event.state_change().terminal();
    if (event.state_change().has_failure())
      line["failure"] = to_json(event.state_change().failure());
  } else if (event.has_message()) {
    line["text"] = event.message().text();
  } else if (event.has_resumed()) {
    line["resumed_step"] = event.resumed().step();
    line["resumed_time_s"] = event.resumed().time_s();
  } else if (event.has_validity_lost()) {
    line["validity_loss"] = to_json(event.validity_lost());
  } else if (event.has_finding()) {
    line["finding"] = to_json(event.finding());
  }
}

}  // namespace

Json WatchOutput::line(const v1::JobEvent& event) {
  if (event.has_state_change()) state_ = event.state_change().state();
  if (event.has_step()) {
    step_ = event.step();
    stepped_ = true;
    // A watch that begins in the middle of a run has not seen it start.
    if (state_ == v1::JOB_STATE_UNSPECIFIED) state_ = v1::RUNNING;
  }
  Json line;
  line["sequence"] = event.sequence();
  line["event"] = event_name(event);
  line["time"] = google::protobuf::util::TimeUtil::ToString(event.time());
  line["state"] = v1::JobState_Name(state_);
  line["step"] = stepped_ ? Json(step_.step()) : Json(nullptr);
  line["time_s"] = stepped_ ? Json(step_.time_s()) : Json(nullptr);
  line["cast_length_m"] = stepped_ ? Json(step_.cast_length_m()) : Json(nullptr);
  line["iterations"] = stepped_ ? Json(step_.iterations()) : Json(nullptr);
  line["beyond_validity"] = step_.beyond_validity();
  line["monitors"] = Json::array();
  for (const v1::MonitorValue& monitor : step_.monitors())
    line["monitors"].push_back(to_json(monitor));
  add_particulars(event, line);
  return line;
}

}  // namespace dccast::client::render
