#include "server/studies/wrong_gauge.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

#include "server/levers/sound_levers.hpp"

namespace dccast::studies {

namespace {

using statistics::TrajectoryForecast;

/// What was expected before the casting, with what the levers have done.
statistics::Estimated expected_with_levers(const TrajectoryForecast& before,
                                           const ExecutedLevers& levers, double time_s) {
  statistics::Estimated expected = before.expected_reading(time_s);
  expected.value += levers.effect_at(time_s).value;
  return expected;
}

/// A reading beside what was expected of it.
struct BesideForecast {
  CurlReading reading;
  statistics::Estimated expected;

  /// How far it is off once a mistake of scale or sign is mended [standard deviations].
  double off(double factor) const {
    return std::abs(reading.curl_m / factor - expected.value) / expected.deviation;
  }
  double expected_size() const { return std::abs(expected.value) / expected.deviation; }
};

constexpr double far = 3.0, near = 2.0;  // [standard deviations]

/// The curls from which a gauge is not far off at some time of the plan [m].
struct CurlRange {
  double least = 0.0, most = 0.0;

  bool contains(double curl) const { return curl >= least && curl <= most; }
};

CurlRange range_of_plan(const TrajectoryForecast& before, const ExecutedLevers& levers,
                        const Eigen::VectorXd& instants) {
  CurlRange range;
  for (const double time_s : instants) {
    const statistics::Estimated expected = expected_with_levers(before, levers, time_s);
    range.least = std::min(range.least, expected.value - far * expected.deviation);
    range.most = std::max(range.most, expected.value + far * expected.deviation);
  }
  return range;
}

/// Whether readings went up to the last one by and by. Those of a gauge that has slipped, or whose
/// zero is wrong, leave a gap.
bool has_grown(std::span<const BesideForecast> readings) {
  constexpr double widest_gap = 0.5;  // of the last reading
  std::vector<double> shares{0.0, 1.0};
  for (const BesideForecast& each : readings)
    shares.push_back(std::clamp(each.reading.curl_m / readings.back().reading.curl_m, 0.0, 1.0));

  std::ranges::sort(shares);
  for (std::size_t i = 1; i < shares.size(); ++i)
    if (shares[i] - shares[i - 1] > widest_gap) return false;
  return true;
}

/// The mistake that explains readings best, and others that leave less than a factor of two of what
/// was expected; empty: none explains nine of ten.
std::string explanation_of(std::span<const BesideForecast> readings) {
  constexpr double most = 0.9;  // share of readings
  double shown = 0.0, expected = 0.0;
  for (const BesideForecast& each : readings) {
    shown += each.reading.curl_m;
    expected += each.expected.value;
  }

  std::map<double, const char*> mistakes;  // by the logarithm of what they leave
  for (const levers::WrongScale& wrong : levers::wrong_scales()) {
    const double scale = shown / expected / wrong.factor;
    const auto explained = std::ranges::count_if(
        readings, [&](const BesideForecast& each) { return each.off(wrong.factor) < near; });
    if (!wrong.of_rates_alone && scale > 0.0 &&
        static_cast<double>(explained) >= most * static_cast<double>(readings.size()))
      mistakes.emplace(std::abs(std::log(scale)), wrong.text);
  }

  std::string text;
  for (const auto& [left, mistake] : mistakes)
    if (text.empty())
      text = mistake;
    else if (left < std::log(2.0))
      text += std::string(", or ") + mistake;
  return text;
}

/// Readings beside what was expected, one for each instant of the plan.
/// @param instants  of the plan [s]
std::vector<BesideForecast> beside_forecast(const TrajectoryForecast& before,
                                            const ExecutedLevers& levers,
                                            const Eigen::VectorXd& instants,
                                            const std::vector<CurlReading>& readings) {
  std::vector<BesideForecast> beside;
  auto reading = readings.begin();
  for (const double time_s : instants) {
    reading = std::find_if(reading, readings.end(),
                           [&](const CurlReading& each) { return each.time_s >= time_s; });
    if (reading == readings.end()) break;
    if (beside.empty() || reading->time_s > beside.back().reading.time_s)
      beside.push_back({*reading, expected_with_levers(before, levers, reading->time_s)});
  }
  return beside;
}

}  // namespace

std::optional<WrongGauge> find_wrong_gauge(const TrajectoryForecast& before,
                                           const Eigen::VectorXd& instants,
                                           const ExecutedLevers& levers,
                                           const std::vector<CurlReading>& readings) {
  constexpr std::size_t window = 10;
  constexpr std::ptrdiff_t most = 8;  // readings of the window that have to agree
  constexpr double visible = 1.5;     // curl that tells scales apart [standard deviations]
  const CurlRange range = range_of_plan(before, levers, instants);
  const auto beside = beside_forecast(before, levers, instants, readings);

  std::vector<BesideForecast> judged;
  for (std::size_t i = 0; i < beside.size(); ++i) {
    if (beside[i].expected_size() <= visible) continue;
    judged.push_back(beside[i]);
    if (judged.size() < window) continue;

    const auto last = std::span(judged).last(window);
    const auto is_far_off = [](const BesideForecast& each) { return each.off(1.0) > far; };
    if (std::ranges::count_if(last, is_far_off) < most) continue;

    // Where little curl is expected against its band, each scale would explain a casting that
    // begins early, and a slip. There a reading has to be beyond all that the plan ever shows.
    const bool grown = has_grown({beside.data(), i + 1});
    const auto unlikely = std::ranges::count_if(last, [&](const BesideForecast& each) {
      return is_far_off(each) &&
             (each.expected_size() > far || (grown && !range.contains(each.reading.curl_m)));
    });
    if (unlikely < most) continue;

    if (std::string mistake = explanation_of(judged); !mistake.empty())
      return WrongGauge{.time_s = beside[i].reading.time_s,
                        .shown_m = beside[i].reading.curl_m,
                        .expected_m = beside[i].expected.value,
                        .mistake = std::move(mistake)};
  }
  return std::nullopt;
}

}  // namespace dccast::studies
