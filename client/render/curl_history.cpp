#include "client/render/curl_history.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dccast::client::render {
namespace {
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
}

double curl_of(const v1::MonitorValue& monitor) {
  return monitor.displacement_m_size() > 1 ? monitor.displacement_m(1) : unknown;
}

void CurlHistory::add(const v1::StepReport& step) {
  time_s.push_back(step.time_s());
  cast_length_m.push_back(step.cast_length_m());
  for (const v1::MonitorValue& value : step.monitors()) {
    auto found = std::find_if(monitors.begin(), monitors.end(),
                              [&](const Series& s) { return s.name == value.name(); });
    if (found == monitors.end()) found = monitors.insert(monitors.end(), {value.name(), {}, {}});
    found->curl_m.resize(time_s.size() - 1, unknown);
    found->horizontal_m.resize(time_s.size() - 1, unknown);
    found->curl_m.push_back(curl_of(value));
    found->horizontal_m.push_back(value.displacement_m_size() > 0 ? value.displacement_m(0)
                                                                  : unknown);
  }
  for (Series& series : monitors) {
    series.curl_m.resize(time_s.size(), unknown);
    series.horizontal_m.resize(time_s.size(), unknown);
  }
}

void CurlHistory::rewind(double last_s) {
  // Times of a step that is computed again are the same to the bit; the margin is for texts.
  while (!time_s.empty() && time_s.back() > last_s + 1e-9) {
    time_s.pop_back();
    cast_length_m.pop_back();
    for (Series& series : monitors) {
      series.curl_m.pop_back();
      series.horizontal_m.pop_back();
    }
  }
}

const CurlHistory::Series* CurlHistory::largest() const {
  const Series* best = nullptr;
  for (const Series& series : monitors)
    if (!series.curl_m.empty() && std::isfinite(series.curl_m.back()) &&
        (best == nullptr || std::abs(series.curl_m.back()) > std::abs(best->curl_m.back())))
      best = &series;
  return best;
}

}  // namespace dccast::client::render
