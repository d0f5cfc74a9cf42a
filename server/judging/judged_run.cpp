#include "server/judging/judged_run.hpp"

#include <algorithm>
#include <limits>

namespace dccast::judging {

std::vector<double> JudgedRun::time_s() const {
  std::vector<double> times;
  std::ranges::transform(steps, std::back_inserter(times), &v1::StepReport::time_s);
  return times;
}

std::vector<double> JudgedRun::cast_length_m() const {
  std::vector<double> lengths;
  std::ranges::transform(steps, std::back_inserter(lengths), &v1::StepReport::cast_length_m);
  return lengths;
}

std::vector<std::string> JudgedRun::monitors() const {
  std::vector<std::string> names;
  for (const v1::StepReport& step : steps)
    for (const v1::MonitorValue& value : step.monitors())
      if (std::ranges::find(names, value.name()) == names.end()) names.push_back(value.name());
  return names;
}

std::vector<double> JudgedRun::curl_m(const std::string& monitor) const {
  std::vector<double> curl(steps.size(), std::numeric_limits<double>::quiet_NaN());
  bool reported = false;

  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto& values = steps[i].monitors();
    const auto found = std::ranges::find(values, monitor, &v1::MonitorValue::name);
    if (found == values.end()) continue;

    reported = true;
    if (found->has_curl_m()) curl[i] = found->curl_m();
  }
  return reported ? curl : std::vector<double>{};
}

}  // namespace dccast::judging
