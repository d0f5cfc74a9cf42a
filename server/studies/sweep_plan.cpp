// The case at many values of some of its keys.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "core/statistics/sampling.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/values/printable.hpp"
#include "server/intake/case_intake.hpp"
#include "server/studies/curl_surface.hpp"
#include "server/studies/study_plan.hpp"

#include <fmt/format.h>

namespace dccast::studies {

namespace {

using intake::fault_of;
using Axis = v1::SweepPlan::Axis;
using RunValues = std::vector<std::vector<std::string>>;  ///< (run, axis), as in a case file

constexpr int most_sweep_runs = 10000;
constexpr int most_grid_axes = 20;
constexpr int most_axes = 100;  // of designs whose runs do not multiply with their axes

bool has_ranges(const v1::SweepPlan& sweep) {
  return sweep.design() == v1::SweepPlan::LATIN_HYPERCUBE || sweep.design() == v1::SweepPlan::ENDS;
}

/// "40 mm/min" as its number and the rest.
struct Written {
  double number = 0.0;
  std::string unit;
};

std::optional<Written> written(std::string text) {
  std::erase_if(text, [](char c) { return c == '"' || c == '\''; });
  Written result;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, result.number);
  if (error != std::errc()) return std::nullopt;
  result.unit.assign(rest, end);
  result.unit.erase(0, result.unit.find_first_not_of(' '));
  return result;
}

/// A place between two ends, in the unit of the first one.
class Range {
public:
  Range(const v1::Case& base, const std::string& key, const std::string& first,
        const std::string& second)
      : whole_(case_file::is_whole_number(base, key)) {
    const auto low = written(first), high = written(second);
    unit_ = low->unit;
    low_ = low->number;
    high_ = unit_ == high->unit
                ? high->number
                : case_file::convert(high->number, high->unit, unit_).value_or(low_);
  }

  std::string at(double place) const {
    const double value = low_ + place * (high_ - low_);
    // Six digits distinguish any two runs, and can be read.
    const std::string number = fmt::format("{:.6g}", whole_ ? std::round(value) : value);
    return unit_.empty() ? number : number + " " + unit_;
  }

private:
  bool whole_;
  double low_ = 0.0, high_ = 0.0;
  std::string unit_;
};

/// Faults of the axes themselves; value_faults() checks their values afterwards.
std::vector<v1::Fault> axis_faults(const v1::SweepPlan& sweep) {
  std::vector<v1::Fault> faults;
  std::set<std::string> keys;

  const int most = sweep.design() == v1::SweepPlan::GRID ? most_grid_axes : most_axes;
  if (sweep.axes().empty() || sweep.axes_size() > most)
    faults.push_back(fault_of("sweep.axes", std::to_string(sweep.axes_size()),
                              "wrong number of keys", "1 to " + std::to_string(most)));

  for (const Axis& axis : sweep.axes()) {
    if (!keys.insert(axis.key()).second)
      faults.push_back(fault_of(axis.key(), "", "is swept twice", "each key once"));
    if (axis.values().empty())
      faults.push_back(fault_of(axis.key(), "", "has no values", "one value or more"));
    if (has_ranges(sweep) && axis.values_size() != 2)
      faults.push_back(fault_of(axis.key(), std::to_string(axis.values_size()) + " values",
                                "this design takes the two ends of a range", "2 values"));
  }
  return faults;
}

/// Number of runs of a plan without axis_faults().
double run_count(const v1::SweepPlan& sweep) {
  if (sweep.design() == v1::SweepPlan::LATIN_HYPERCUBE) return sweep.runs();
  if (sweep.design() == v1::SweepPlan::LIST) return sweep.axes(0).values_size();
  if (sweep.design() == v1::SweepPlan::ENDS) return 1 + 2 * sweep.axes_size();
  double product = 1.0;
  for (const Axis& axis : sweep.axes()) product *= axis.values_size();
  return product;
}

/// Faults of the design and of its number of runs.
std::vector<v1::Fault> design_faults(const v1::SweepPlan& sweep) {
  if (!v1::SweepPlan::Design_IsValid(sweep.design()) ||
      sweep.design() == v1::SweepPlan::DESIGN_UNSPECIFIED)
    return {fault_of("sweep.design", "", "is absent", "GRID, LIST, LATIN_HYPERCUBE, ENDS")};

  std::vector<v1::Fault> faults;
  const double runs = run_count(sweep);
  if (runs < 1 || runs > most_sweep_runs)
    faults.push_back(fault_of("sweep.runs", case_file::number_text(runs), "wrong number of runs",
                              "1 to " + std::to_string(most_sweep_runs)));

  // What a study cannot answer is refused before it computes for minutes.
  const bool needs_surface = sweep.purpose() == v1::SweepPlan::UNCERTAINTY ||
                             sweep.purpose() == v1::SweepPlan::CALIBRATION;
  const auto fewest = CurlSurface::fewest_runs(static_cast<std::size_t>(sweep.axes_size()));
  if (sweep.design() == v1::SweepPlan::LATIN_HYPERCUBE && needs_surface && runs >= 1 &&
      runs < static_cast<double>(fewest))
    faults.push_back(fault_of("sweep.runs", case_file::number_text(runs),
                              fmt::format("are too few to tell {} keys apart", sweep.axes_size()),
                              fmt::format("{} or more", fewest),
                              fmt::format("make {} runs, or vary fewer keys", fewest)));

  if (sweep.design() == v1::SweepPlan::LIST)
    for (const Axis& axis : sweep.axes())
      if (axis.values_size() != sweep.axes(0).values_size())
        faults.push_back(fault_of(axis.key(), std::to_string(axis.values_size()) + " values",
                                  "a list takes as many values of every key",
                                  std::to_string(sweep.axes(0).values_size()) + " values"));
  return faults;
}

/// Checks that the two values of an axis are numbers with convertible units in ascending order.
std::vector<v1::Fault> range_faults(const v1::Case& base, const Axis& axis) {
  const auto low = written(axis.values(0)), high = written(axis.values(1));
  const bool comparable =
      low && high && (low->unit == high->unit || case_file::convertible(high->unit, low->unit));
  const double from = number_of(base, axis.key(), axis.values(0));
  const double to = number_of(base, axis.key(), axis.values(1));
  if (comparable && from < to) return {};
  return {fault_of(axis.key(), axis.values(0) + ", " + axis.values(1), "is no range",
                   "two numbers with units, the smaller one first")};
}

/// Applies every value to the case by itself, and reports those that the schema refuses.
std::vector<v1::Fault> value_faults(const v1::CreateStudyRequest& request) {
  std::vector<v1::Fault> faults;
  const bool ranges = request.sweep().design() == v1::SweepPlan::LATIN_HYPERCUBE;
  for (const Axis& axis : request.sweep().axes()) {
    const std::size_t before = faults.size();

    for (const std::string& value : axis.values()) {
      v1::Case changed = request.case_();
      const auto found =
          case_file::apply_changes(changed, {case_file::change_of(axis.key(), value)});
      faults.insert(faults.end(), found.begin(), found.end());
    }

    // A range of values that cannot be read would only repeat the fault.
    if (!ranges || faults.size() > before) continue;
    const auto found = range_faults(request.case_(), axis);
    faults.insert(faults.end(), found.begin(), found.end());
  }
  return faults;
}

using Field = google::protobuf::RepeatedField<double>;

bool all_finite(const Field& values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

/// First fault of a measured curve and its readings, if any.
std::optional<v1::Fault> curve_fault(const std::string& field, const v1::MeasuredCurve& curve) {
  if (values::unprintable(curve.source()) || !values::too_long("source", curve.source()).empty())
    return fault_of(field + ".source", values::shortened(values::escaped(curve.source())),
                    "is no name of a file", "one line of at most 200 bytes");

  const Field& instants = curve.time_s_size() > 0 ? curve.time_s() : curve.cast_length_m();
  const Field& values = curve.curl_m_size() > 0 ? curve.curl_m() : curve.temperature_c();
  const bool one_each = (curve.time_s_size() > 0) != (curve.cast_length_m_size() > 0) &&
                        (curve.curl_m_size() > 0) != (curve.temperature_c_size() > 0);
  if (!one_each || instants.size() != values.size() || instants.size() < 2)
    return fault_of(field, fmt::format("{} values", values.size()), "readings are not complete",
                    "times or cast lengths, as many curls or temperatures, 2 or more");

  if (!all_finite(instants) || !all_finite(values) || !std::isfinite(curve.noise()) ||
      curve.noise() < 0.0)
    return fault_of(field, "", "has readings that are no numbers", "finite numbers");
  if (std::ranges::adjacent_find(instants, std::greater_equal()) != instants.end())
    return fault_of(field, "", "readings are not in order", "each later than the last");
  return std::nullopt;
}

/// Faults of all measured curves, and of measurements in a design that cannot use them.
std::vector<v1::Fault> measurement_faults(const v1::CreateStudyRequest& request) {
  std::vector<v1::Fault> faults;
  const auto& curves = request.sweep().measured();
  if (!curves.empty() && request.sweep().design() != v1::SweepPlan::LATIN_HYPERCUBE)
    faults.push_back(fault_of("sweep.measured", "", "needs a Latin hypercube", "none"));

  for (int i = 0; i < curves.size(); ++i) {
    const std::string field = fmt::format("sweep.measured[{}]", i);
    const v1::MeasuredCurve& curve = curves[i];

    std::string monitors;
    bool known = false;
    for (const v1::Monitor& monitor : request.case_().monitor()) {
      monitors += (monitors.empty() ? "" : ", ") + monitor.name();
      known = known || monitor.name() == curve.monitor();
    }

    if (!known)
      faults.push_back(
          fault_of(field + ".monitor", curve.monitor(), "the case has no such monitor", monitors));
    if (auto fault = curve_fault(field, curve)) faults.push_back(std::move(*fault));
  }
  return faults;
}

/// Whether an axis may change what is known of the error of mesh and time steps.
bool changes_mesh(const Axis& axis) {
  const std::string table = axis.key().substr(0, axis.key().find('.'));
  return table == "quality" || table == "mesh" || table == "time" || table == "section";
}

/// Every value with every other, those of the last axis fastest.
RunValues grid_values(const v1::SweepPlan& sweep) {
  RunValues runs{{}};
  for (const Axis& axis : sweep.axes()) {
    RunValues longer;
    for (const auto& run : runs)
      for (const std::string& value : axis.values()) {
        longer.push_back(run);
        longer.back().push_back(value);
      }
    runs = std::move(longer);
  }
  return runs;
}

RunValues hypercube_values(const v1::CreateStudyRequest& request) {
  const v1::SweepPlan& sweep = request.sweep();
  const auto places = statistics::hypercube(sweep.runs(), sweep.axes_size(), sweep.seed());
  RunValues runs(sweep.runs());
  for (int axis = 0; axis < sweep.axes_size(); ++axis) {
    const Axis& ends = sweep.axes(axis);
    const Range range(request.case_(), ends.key(), ends.values(0), ends.values(1));
    for (int run = 0; run < sweep.runs(); ++run) runs[run].push_back(range.at(places(run, axis)));
  }
  return runs;
}

/// The case itself, then each axis alone at its two ends; an empty value is that of the case.
RunValues end_values(const v1::SweepPlan& sweep) {
  const std::vector<std::string> itself(sweep.axes_size());
  RunValues runs{itself};
  for (int axis = 0; axis < sweep.axes_size(); ++axis)
    for (const std::string& end : sweep.axes(axis).values()) {
      runs.push_back(itself);
      runs.back()[axis] = end;
    }
  return runs;
}

/// Values of each run. @param request  with a sweep without faults
RunValues sweep_values(const v1::CreateStudyRequest& request) {
  const v1::SweepPlan& sweep = request.sweep();
  if (sweep.design() == v1::SweepPlan::LATIN_HYPERCUBE) return hypercube_values(request);
  if (sweep.design() == v1::SweepPlan::ENDS) return end_values(sweep);
  if (sweep.design() == v1::SweepPlan::GRID) return grid_values(sweep);
  RunValues runs(sweep.axes(0).values_size());
  for (const Axis& axis : sweep.axes())
    for (int run = 0; run < axis.values_size(); ++run) runs[run].push_back(axis.values(run));
  return runs;
}

/// What a run changes, for messages. Of many changes the first few.
std::string describe_changes(const std::vector<v1::CaseChange>& changes) {
  constexpr std::size_t most = 4;
  if (changes.empty()) return "the case itself";

  std::vector<std::string> words;
  for (const v1::CaseChange& change : changes) {
    if (words.size() == most) break;
    words.push_back(fmt::format("{} = {}", change.key(), change.value()));
  }
  if (changes.size() > most) words.push_back(fmt::format("{} more", changes.size() - most));
  return fmt::format("{}", fmt::join(words, ", "));
}

class Sweep final : public StudyPlan {
public:
  explicit Sweep(const v1::CreateStudyRequest& request)
      : base_(request.case_()),
        sweep_(request.sweep()),
        values_(sweep_values(request)),
        one_error_(std::ranges::none_of(sweep_.axes(), changes_mesh)),
        base_error_(mesh_error(base_)) {
    for (int run = 0; run < runs(); ++run)
      for (int axis = 0; axis < sweep_.axes_size(); ++axis) {
        const auto known = numbers_.try_emplace({axis, value(run, axis)});
        if (known.second)
          known.first->second = number_of(base_, sweep_.axes(axis).key(), value(run, axis));
      }
  }

  int runs() const override { return static_cast<int>(values_.size()); }

  PlannedRun run(int number) const override {
    std::vector<v1::CaseChange> changes;
    for (int axis = 0; axis < sweep_.axes_size(); ++axis)
      if (!value(number, axis).empty())  // otherwise as in the case
        changes.push_back(case_file::change_of(sweep_.axes(axis).key(), value(number, axis)));

    std::string name = fmt::format("run {} ({})", key(number), describe_changes(changes));
    return planned(number, std::move(name), base_, std::move(changes));
  }

  void describe(int number, v1::StudyRun& run) const override {
    for (int axis = 0; axis < sweep_.axes_size(); ++axis) {
      run.add_values(value(number, axis));
      run.add_numbers(numbers_.at({axis, value(number, axis)}));
    }
    const auto error = one_error_ ? base_error_ : mesh_error(this->run(number).description);
    if (error) *run.mutable_mesh_error() = *error;
  }

private:
  const std::string& value(int number, int axis) const { return values_[number][axis]; }

  v1::Case base_;
  v1::SweepPlan sweep_;
  RunValues values_;
  std::map<std::pair<int, std::string>, double> numbers_;  ///< by axis and value
  bool one_error_;  ///< of mesh and time steps, for all runs: base_error_
  std::optional<v1::RelativeError> base_error_;
};

}  // namespace

double number_of(const v1::Case& base, const std::string& key, const std::string& value) {
  v1::Case changed = base;
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (!case_file::apply_changes(changed, {case_file::change_of(key, value)}).empty()) return none;
  // The swept quantity is the factor, also that of "0.8 until 100 mm", or the offset.
  if (key.ends_with(".scale") || key.ends_with(".offset"))
    if (const auto change = written(value))
      return change->unit.starts_with("%") ? 0.01 * change->number : change->number;
  return case_file::number_at(changed, key).value_or(none);
}

std::optional<v1::RelativeError> mesh_error(v1::Case description) {
  case_file::apply_quality(description);
  case_file::apply_defaults(description);
  return case_file::relative_discretisation_error(description);
}

std::string value_between(const v1::Case& base, const std::string& key, const std::string& low,
                          const std::string& high, double place) {
  return Range(base, key, low, high).at(place);
}

std::vector<v1::Fault> sweep_faults(const v1::CreateStudyRequest& request) {
  auto faults = axis_faults(request.sweep());
  if (faults.empty()) faults = design_faults(request.sweep());
  if (faults.empty()) faults = measurement_faults(request);
  if (faults.empty()) faults = value_faults(request);
  return faults;
}

std::unique_ptr<StudyPlan> sweep_plan(const v1::CreateStudyRequest& request) {
  return std::make_unique<Sweep>(request);
}

}  // namespace dccast::studies
