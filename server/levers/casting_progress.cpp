#include "server/levers/casting_progress.hpp"

#include <algorithm>

namespace dccast::levers {

namespace {

/// The run keeps the last value of a lever as long (core/casting/case/lever_record.hpp).
constexpr double longest_gap_s = 10.0;

/// Each lever and curl as it was measured last.
v1::Reading last_values(const std::deque<v1::Reading>& readings) {
  v1::Reading values;
  for (const v1::Reading& reading : readings) {
    // A merge adds curls, so that earlier ones of the same gauges are removed first.
    for (const v1::MeasuredCurl& curl : reading.curls()) {
      const auto is_same = [&](const v1::MeasuredCurl& known) {
        return known.monitor() == curl.monitor();
      };
      auto& curls = *values.mutable_curls();
      curls.erase(std::remove_if(curls.begin(), curls.end(), is_same), curls.end());
    }
    values.MergeFrom(reading);
  }
  return values;
}

}  // namespace

void CastingProgress::follow(const v1::Reading& reading) {
  if (reading.closes()) {
    closed_ = true;
    return;
  }
  watch_.follow(reading);
  last_.push_back(reading);
  while (last_.front().time_s() < reading.time_s() - longest_gap_s) last_.pop_front();
}

v1::CastingNow CastingProgress::now() const {
  v1::CastingNow now;
  if (closed_) now.set_closed(true);
  if (last_.empty()) return now;

  *now.mutable_measured() = last_values(last_);
  *now.mutable_planned() = watch_.planned();
  for (v1::ForecastWarning& alarm : watch_.under_way()) *now.add_alarms() = std::move(alarm);
  return now;
}

}  // namespace dccast::levers
