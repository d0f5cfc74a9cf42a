#include "server/studies/executed_levers.hpp"

#include <algorithm>
#include <cmath>

#include "proto/values/interpolation.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

namespace {

/// How uncertain an effect is a minute after it is known last, as a share of it
/// (docs/forecasts.md).
constexpr double share_after_minute = 0.5;

}  // namespace

double minute_share(double time_s, double since_s) {
  constexpr double minute_s = 60.0;
  return std::clamp((time_s - since_s) / minute_s, 0.0, 1.0);
}

ExecutedLevers::ExecutedLevers(const v1::CurlCurve& followed, const v1::CurlCurve& planned) {
  const auto planned_m =
      at_instants({followed.time_s().begin(), followed.time_s().end()}, planned, planned.curl_m());
  for (int i = 0; i < followed.time_s_size(); ++i) {
    const double effect_m = followed.curl_m(i) - planned_m[static_cast<std::size_t>(i)];
    if (!std::isfinite(effect_m)) continue;  // one of the runs has no curl yet
    time_s_.push_back(followed.time_s(i));
    effect_m_.push_back(effect_m);
  }
}

statistics::Estimated ExecutedLevers::effect_at(double time_s, double known_until_s) const {
  if (time_s_.empty() || known_until_s < time_s_.front()) return {};

  const double known_s = std::min(known_until_s, time_s_.back());
  const double at_s = std::clamp(time_s, time_s_.front(), known_s);
  const double effect_m = values::at_instants({at_s}, time_s_, effect_m_).front();
  return {effect_m, share_after_minute * minute_share(time_s, known_s) * std::abs(effect_m)};
}

}  // namespace dccast::studies
