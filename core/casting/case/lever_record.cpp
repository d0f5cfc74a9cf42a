#include "core/casting/case/lever_record.hpp"

#include <algorithm>
#include <stdexcept>

namespace dccast::casting {

namespace {

/// The lever at a time between two readings that follow each other; empty if it is not known.
std::optional<double> between(const LeverReading& a, const LeverReading& b, Lever lever,
                              double time) {
  const std::optional<double>&from = a.of(lever), &to = b.of(lever);
  if (!from || !to || b.time - a.time > LeverRecord::longest_gap) return std::nullopt;
  return *from + (time - a.time) / (b.time - a.time) * (*to - *from);
}

auto first_at_or_after(const std::vector<LeverReading>& rows, double time) {
  return std::ranges::lower_bound(rows, time, {}, &LeverReading::time);
}

/// Adds a stretch up to a time to those before it, of the last of which it may be a part.
void add(std::vector<LeverStretch>& stretches, double from, double to,
         std::optional<double> integral) {
  if (to <= from) return;
  const bool goes_on =
      !stretches.empty() && stretches.back().integral.has_value() == integral.has_value();
  if (!goes_on) {
    stretches.push_back({from, to, integral});
    return;
  }
  stretches.back().to = to;
  if (integral) *stretches.back().integral += *integral;
}

}  // namespace

void LeverRecord::append(const LeverReading& reading) {
  if (!rows_.empty() && reading.time <= last())
    throw std::invalid_argument("a reading of the levers is not later than the one before");

  LeverReading row = reading;
  for (std::size_t lever = 0; lever < row.value.size(); ++lever) {
    if (row.value[lever])
      measured_[lever] = row.time;
    else if (!rows_.empty() && row.time - measured_[lever] <= longest_gap)
      row.value[lever] = rows_.back().value[lever];
  }
  rows_.push_back(row);
}

std::optional<double> LeverRecord::at(Lever lever, double time) const {
  const auto next = first_at_or_after(rows_, time);
  if (next == rows_.end()) return std::nullopt;
  if (next->time == time) return next->of(lever);
  if (next == rows_.begin()) return std::nullopt;
  return between(*(next - 1), *next, lever, time);
}

std::vector<LeverStretch> LeverRecord::stretches(Lever lever, double from, double to) const {
  std::vector<LeverStretch> divided;
  for (auto next = first_at_or_after(rows_, from); next != rows_.end() && from < to; ++next) {
    const double end = std::min(next->time, to);
    std::optional<double> integral;
    if (next != rows_.begin()) {
      const auto at_begin = between(*(next - 1), *next, lever, from);
      const auto at_end = between(*(next - 1), *next, lever, end);
      if (at_begin && at_end) integral = 0.5 * (*at_begin + *at_end) * (end - from);
    }
    add(divided, from, end, integral);
    from = std::max(from, end);
  }
  add(divided, from, to, std::nullopt);
  return divided;
}

}  // namespace dccast::casting
