#include "client/session/source_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "proto/case_file/quantity.hpp"

namespace dccast::client {

namespace {

constexpr std::size_t most_lines = 3600;  // that are remembered, an hour at one a second
constexpr std::size_t most_steps = 15;    // of which the usual one is the median
constexpr std::size_t fewest_steps = 3;
constexpr double least_step_s = 1e-4;  // above the rounding of the longest time on a clock
constexpr double least_jump_s = 5.0;   // of a source in real time
constexpr double usual_jump_from_s = 60.0;
constexpr double many_pauses = 10.0;  // a longer step is remarked
constexpr double few_pauses = 3.0;    // a line that comes within them is in time

}  // namespace

std::optional<double> SourceClock::usual(const std::deque<double>& steps) {
  if (steps.size() < fewest_steps) return std::nullopt;
  std::vector<double> sorted(steps.begin(), steps.end());
  const auto middle = sorted.begin() + std::ssize(sorted) / 2;
  std::ranges::nth_element(sorted, middle);
  return *middle;
}

bool SourceClock::is_in_real_time() const {
  const auto step_s = usual(steps_s_), pause_s = usual(pauses_s_);
  return step_s && pause_s && *pause_s > 0.5 * *step_s && *pause_s < 2.0 * *step_s;
}

bool SourceClock::is_set_back(const Line& line) const {
  const auto step_s = usual(steps_s_);
  if (!step_s) return false;

  // No line is late that is from before the first one.
  if (lines_.front().time_s - line.time_s > *step_s) return true;
  // Between two lines that follow each other as usual no further one belongs.
  const auto next = std::ranges::lower_bound(lines_, line.time_s, {}, &Line::time_s);
  if (next == lines_.end() || next == lines_.begin()) return false;
  const auto before = next - 1;
  const bool is_doubled =
      next->time_s - line.time_s < least_step_s && next->mark.content == line.mark.content;
  return !is_doubled && next->time_s - before->time_s < 1.5 * *step_s;
}

SourceClock::Placed SourceClock::jump(double to_s, const Line& line, const std::string& reason) {
  offset_s_ += to_s - line.time_s;
  history_.jumps.resize(passed_++);
  history_.jumps.push_back({line.mark, offset_s_});
  return {.time_s = to_s,
          .is_jump = true,
          .remark = fmt::format("jumps by {:+.4g} s: {}", line.time_s - to_s, reason)};
}

void SourceClock::begin(const Mark& first) {
  if (history_.jumps.empty()) history_.first = first;
  if (first == history_.first) return;
  // A line before the first jump has an earlier stamp, unless that jump has set the clock back.
  const auto& jumps = history_.jumps;
  for (std::size_t i = jumps.size(); i > 0 && passed_ == 0; --i)
    if (first.stamp_s >= jumps[i - 1].at.stamp_s) passed_ = i;
  if (passed_ > 0) offset_s_ = jumps[passed_ - 1].offset_s;
}

bool SourceClock::meets_known_jump(const Mark& mark) {
  if (passed_ == history_.jumps.size() || history_.jumps[passed_].at != mark) return false;
  offset_s_ = history_.jumps[passed_++].offset_s;
  return true;
}

SourceClock::Placed SourceClock::place_earlier(const Line& line, std::optional<double> elapsed_s) {
  const auto before = std::exchange(back_, line);
  const auto step_s = usual(steps_s_);
  const bool goes_on = before && line.time_s > before->time_s && step_s &&
                       line.time_s - before->time_s < few_pauses * *step_s;
  if (!goes_on || !is_set_back(line) || !is_set_back(*before))
    return {.time_s = line.time_s, .is_earlier = true};

  // The line before, which was left out, came a usual pause after the last one.
  const double since_s =
      is_in_real_time() && elapsed_s ? *elapsed_s : *step_s + (line.time_s - before->time_s);
  return jump(lines_.back().time_s + since_s, line,
              "the lines go on from an earlier time, which is a clock that was set back. Later "
              "stamps are moved by as much; a table with lines in another order is to be sorted");
}

SourceClock::Placed SourceClock::place_later(const Line& line, std::optional<double> elapsed_s) {
  const double last_s = lines_.back().time_s, long_s = line.time_s - last_s;
  const auto step_s = usual(steps_s_), pause_s = usual(pauses_s_);
  if (!step_s) return {.time_s = line.time_s};

  if (is_in_real_time() && elapsed_s) {
    const double lead_s = line.time_s - (*last_arrival_s_ + *elapsed_s) - ahead_s_.value_or(0.0);
    const bool is_late_stamp = *elapsed_s - long_s >= least_jump_s &&
                               *step_s - long_s >= least_jump_s &&
                               *elapsed_s <= few_pauses * *pause_s;
    if (lead_s < least_jump_s && !is_late_stamp) return {.time_s = line.time_s};
    return jump(last_s + *elapsed_s, line,
                fmt::format("the stamps are {:.4g} s apart, the lines came {:.4g} s apart. The "
                            "arrival counts, and later stamps are moved by as much",
                            long_s, *elapsed_s));
  }

  const double from_s = jump_from_s_.value_or(std::max(usual_jump_from_s, many_pauses * *step_s));
  if (long_s <= many_pauses * *step_s && long_s < from_s) return {.time_s = line.time_s};
  if (long_s < from_s)
    return {.time_s = line.time_s,
            .remark = fmt::format("taken for a gap; if the clock jumped there: --jump-from \"{}\"",
                                  case_file::quantity_text(std::floor(long_s), "s"))};
  return jump(last_s + *step_s, line,
              fmt::format("no reading for {:.4g} s is taken for a clock that was set, and later "
                          "stamps are moved by as much; if there was none for so long: --jump-from "
                          "\"{}\"",
                          long_s, case_file::quantity_text(std::ceil(long_s) + 1.0, "s")));
}

void SourceClock::accept(const Line& line, std::optional<double> arrival_s) {
  const auto keep = [](std::deque<double>& steps, double step) {
    steps.push_back(step);
    if (steps.size() > most_steps) steps.pop_front();
  };
  if (!lines_.empty()) keep(steps_s_, line.time_s - lines_.back().time_s);
  if (arrival_s && last_arrival_s_) keep(pauses_s_, *arrival_s - *last_arrival_s_);
  // The lead shrinks slowly, so that clocks may run apart.
  constexpr double drift = 1e-3;
  if (arrival_s) {
    const double lead_s = line.time_s - *arrival_s;
    const double kept_s = ahead_s_ ? *ahead_s_ - drift : lead_s;
    ahead_s_ = std::max(lead_s, kept_s);
    last_arrival_s_ = arrival_s;
  }
  lines_.push_back(line);
  if (lines_.size() > most_lines) lines_.pop_front();
}

SourceClock::Placed SourceClock::place(double time_s, std::optional<double> arrival_s,
                                       std::size_t content) {
  const Mark mark{time_s, content};
  if (lines_.empty()) begin(mark);
  const bool is_known = meets_known_jump(mark);
  const Line line{time_s + offset_s_, mark};
  std::optional<double> elapsed_s;
  if (arrival_s && last_arrival_s_) elapsed_s = *arrival_s - *last_arrival_s_;

  Placed placed{.time_s = line.time_s};
  if (!lines_.empty() && line.time_s < lines_.back().time_s + least_step_s)
    placed = place_earlier(line, elapsed_s);
  else if (!lines_.empty() && !is_known)
    placed = place_later(line, elapsed_s);

  if (placed.is_earlier) return placed;
  back_.reset();
  accept({placed.time_s, mark}, arrival_s);
  return placed;
}

}  // namespace dccast::client
