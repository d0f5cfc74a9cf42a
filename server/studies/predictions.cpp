#include "server/studies/predictions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/text_checks.hpp"
#include "server/jobs/log.hpp"
#include "server/studies/curl_surface.hpp"
#include "server/studies/sweep_plan.hpp"

namespace dccast::studies {

namespace {

// A surface may be out of date while runs arrive, so that no more than this share of the time goes
// into building it.
constexpr int building_share = 20;
// A sweep of many alloys has a surface for each; further ones are built when they are asked for.
constexpr std::size_t most_prepared = 8;
constexpr int fewest_prepared = 16;              // runs; with fewer a surface takes no time
constexpr std::size_t most_bytes = 256'000'000;  // of all surfaces that are kept
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// One axis of a sweep: numbers are the inputs of surfaces, other values choose among them.
struct SweptKey {
  std::string key;
  bool numeric = true;
  InputRange range;                 ///< of a numeric one, in the unit of the schema
  std::string low, high;            ///< as written
  std::vector<std::string> values;  ///< of another one
};

SweptKey swept_key(const v1::Case& base, const v1::SweepPlan::Axis& axis) {
  SweptKey key{axis.key(), true, {}, {}, {}, {axis.values().begin(), axis.values().end()}};
  for (const std::string& value : key.values) {
    const double number = number_of(base, axis.key(), value);
    key.numeric = key.numeric && std::isfinite(number);
    if (key.low.empty() || number < key.range.low) key.low = value, key.range.low = number;
    if (key.high.empty() || number > key.range.high) key.high = value, key.range.high = number;
  }
  return key;
}

/// Where a prediction is asked for.
struct Place {
  std::vector<double> inputs;  ///< of the numeric keys
  std::string kind;            ///< values of the others
};

std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : ", ") + text;
  return all;
}

[[noreturn]] void outside(const SweptKey& key, const std::string& value) {
  throw OutsideDomain(key.key + " = " + value +
                      " is outside of what the study has run; permitted: " +
                      (key.numeric ? key.low + " to " + key.high : joined(key.values)));
}

/// The number of a key that is asked for, or that of the case. @param given  null: not asked for
double input_of(const v1::Case& base, const SweptKey& key, const std::string* given) {
  constexpr double margin = 1e-9;  // of a value that was converted from another unit
  const double number = given != nullptr ? number_of(base, key.key, *given)
                                         : case_file::number_at(base, key.key).value_or(unknown);
  if (given != nullptr && !std::isfinite(number))
    throw FaultyPlace(key.key + " = " + *given + " cannot be read; permitted: " + key.low + " to " +
                      key.high);
  if (given == nullptr && !std::isfinite(number))
    throw FaultyPlace("give a value of " + key.key + ", " + key.low + " to " + key.high +
                      ": the case has none of its own");
  const double allowed = margin * std::max(std::abs(key.range.low), std::abs(key.range.high));
  if (number < key.range.low - allowed || number > key.range.high + allowed)
    outside(key, given != nullptr ? *given : "as in the case, which is not given");
  return number;
}

[[noreturn]] void not_swept(const std::string& key, const std::vector<SweptKey>& keys) {
  std::vector<std::string> names;
  for (const SweptKey& swept : keys) names.push_back(swept.key);
  const std::string near = case_file::nearest(key, names);
  throw FaultyPlace(key + " was not swept; " + (near.empty() ? "" : "did you mean " + near + "? ") +
                    "the keys of this study are " + joined(names));
}

Place place_of(const v1::Case& base, const std::vector<SweptKey>& keys,
               const v1::PredictStudyRequest& request) {
  std::map<std::string, std::string> given;
  for (const v1::CaseChange& change : request.values()) {
    if (std::ranges::find(keys, change.key(), &SweptKey::key) == keys.end())
      not_swept(change.key(), keys);
    given[change.key()] = change.value();
  }
  Place place;
  for (const SweptKey& key : keys) {
    const auto found = given.find(key.key);
    const std::string* value = found == given.end() ? nullptr : &found->second;
    if (key.numeric) {
      place.inputs.push_back(input_of(base, key, value));
    } else {
      if (value == nullptr)
        throw FaultyPlace("give a value of " + key.key + ": " + joined(key.values));
      if (std::ranges::find(key.values, *value) == key.values.end()) outside(key, *value);
      place.kind += *value + "\n";
    }
  }
  return place;
}

/// A text of a case file for a place on a numeric key, 0 to 1.
std::string text_at(const v1::Case& base, const SweptKey& key, double place) {
  v1::SweepPlan::Axis ends;
  ends.set_key(key.key);
  ends.add_values(key.low);
  ends.add_values(key.high);
  return value_between(base, ends, place);
}

/// The values of a run's keys that are no numbers.
std::string kind_of(const std::vector<SweptKey>& keys, const EvaluatedRun& run) {
  std::string kind;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (!keys[i].numeric) kind += run.run.values(static_cast<int>(i)) + "\n";
  return kind;
}

/// Between runs of one key each nothing is known of two.
void require_design(const StudyRecord& study) {
  if (study.request.sweep().design() == v1::SweepPlan::ENDS)
    throw CannotPredict("study " + study.id +
                        " changes one key at a time; dccast sweep --lhs "
                        "makes runs to predict from");
}

/// Those of the first runs, as many as are prepared.
std::set<std::string> kinds_of(const std::vector<SweptKey>& keys,
                               const std::vector<EvaluatedRun>& runs) {
  std::set<std::string> kinds;
  for (const EvaluatedRun& run : runs)
    if (run.counts() && kinds.size() < most_prepared) kinds.insert(kind_of(keys, run));
  return kinds;
}

}  // namespace

/// The axes of a sweep. To read all values of a long list takes longer than to predict.
struct SweptKeys {
  v1::Case base;  ///< with its defaults
  std::vector<SweptKey> all;
};

/// A surface with the names of its inputs.
class SweepSurface {
public:
  SweepSurface(const StudyRecord& study, const std::vector<SweptKey>& keys, const std::string& kind,
               const std::vector<EvaluatedRun>& runs)
      : keys_(keys) {
    std::vector<SurfaceRun> chosen;
    for (const EvaluatedRun& run : runs)
      if (run.counts() && kind_of(keys_, run) == kind) add(run, chosen);
    std::vector<InputRange> domain;
    for (const SweptKey& key : keys_)
      if (key.numeric) domain.push_back(key.range);
    const std::size_t fewest = CurlSurface::fewest_runs(domain.size());
    if (domain.empty()) throw CannotPredict("no key of this study has numbers to interpolate");
    if (chosen.size() < fewest)
      throw CannotPredict("a prediction over " + std::to_string(domain.size()) + " keys needs " +
                          std::to_string(fewest) + " valid runs that succeeded, and " +
                          std::to_string(chosen.size()) + " have; wait for more, or sweep more");
    std::vector<std::string> monitors;
    for (const v1::Monitor& monitor : study.request.case_().monitor())
      monitors.push_back(monitor.name());
    surface_ = std::make_unique<CurlSurface>(std::move(domain), chosen, monitors);
    name_next_run(study.request.case_());
  }

  v1::Prediction predict(const std::vector<double>& inputs) const {
    v1::Prediction prediction;
    for (v1::CurlCurve& curve : surface_->predict(inputs))
      *prediction.add_curves() = std::move(curve);
    prediction.set_cross_validated_error_m(surface_->cross_validated_error_m());
    prediction.set_runs(surface_->runs());
    *prediction.mutable_next_run() = {next_run_.begin(), next_run_.end()};
    if (std::isfinite(curl_error_)) prediction.set_relative_curl_error(curl_error_);
    return prediction;
  }

  const CurlSurface& surface() const { return *surface_; }
  std::size_t bytes() const { return surface_->bytes(); }

private:
  void add(const EvaluatedRun& run, std::vector<SurfaceRun>& chosen) {
    std::vector<double> inputs;
    for (std::size_t i = 0; i < keys_.size(); ++i)
      if (keys_[i].numeric) inputs.push_back(run.run.numbers(static_cast<int>(i)));
    chosen.push_back({std::move(inputs), run.history});
    curl_error_ = std::max(curl_error_, run.run.has_relative_curl_error()
                                            ? run.run.relative_curl_error()
                                            : std::numeric_limits<double>::infinity());
  }

  void name_next_run(const v1::Case& base) {
    auto place = surface_->next_place().begin();
    for (const SweptKey& key : keys_) {
      if (!key.numeric) continue;
      v1::CaseChange& change = next_run_.emplace_back();
      change.set_key(key.key);
      change.set_value(text_at(base, key, *place++));
    }
  }

  std::vector<SweptKey> keys_;
  std::unique_ptr<const CurlSurface> surface_;
  std::vector<v1::CaseChange> next_run_;
  double curl_error_ = 0.0;  ///< largest of the runs, relative; infinite: not known of one of them
};

Predictions::Predictions() = default;
Predictions::~Predictions() = default;

std::shared_ptr<const SweptKeys> Predictions::keys_of(const StudyRecord& study) {
  const std::lock_guard lock(mutex_);
  if (const auto kept = keys_.find(study.id); kept != keys_.end()) return kept->second;
  SweptKeys keys{study.request.case_(), {}};
  case_file::apply_quality(keys.base);
  case_file::apply_defaults(keys.base);
  for (const auto& axis : study.request.sweep().axes())
    keys.all.push_back(swept_key(study.request.case_(), axis));
  return keys_[study.id] = std::make_shared<const SweptKeys>(std::move(keys));
}

/// @param of_fewer_runs  also one that is out of date  @return null where it is missing
Predictions::Surface Predictions::kept_surface(const Wanted& wanted, bool of_fewer_runs) {
  const std::lock_guard lock(mutex_);
  const auto study = kept_.find(wanted.study.id);
  if (study == kept_.end()) return nullptr;
  const auto found = study->second.find(wanted.kind);
  if (found == study->second.end()) return nullptr;
  Kept& kept = found->second;
  kept.used = Clock::now();
  const bool recent = wanted.running && kept.used - kept.built < building_share * kept.took;
  return kept.succeeded == wanted.succeeded || recent || of_fewer_runs ? kept.surface : nullptr;
}

Predictions::Surface Predictions::surface_of(const Wanted& wanted,
                                             const std::function<Surface()>& build) {
  if (auto surface = kept_surface(wanted)) return surface;
  std::unique_lock one_at_a_time(building_, std::try_to_lock);
  if (!one_at_a_time) {
    // While runs arrive, the answer of a surface of fewer of them now is worth more than a
    // better one later: the prediction has how many it rests on.
    if (auto older = wanted.running ? kept_surface(wanted, true) : nullptr) return older;
    one_at_a_time.lock();
  }
  if (auto surface = kept_surface(wanted)) return surface;  // built while we waited
  const auto begin = Clock::now();
  Surface surface = build();
  keep(wanted, surface, begin);
  return surface;
}

void Predictions::keep(const Wanted& wanted, Surface surface, Clock::time_point begin) {
  const auto now = Clock::now();
  log::debug("study {}: response surface of {} runs in {} ms", wanted.study.id, wanted.succeeded,
             std::chrono::duration_cast<std::chrono::milliseconds>(now - begin).count());
  const std::lock_guard lock(mutex_);
  kept_[wanted.study.id][wanted.kind] = {std::move(surface), wanted.succeeded, now, now - begin,
                                         now};
  make_room();
}

/// Lets go of those asked for longest ago, save the last one.
void Predictions::make_room() {
  for (;;) {
    std::size_t bytes = 0, count = 0;
    auto oldest = Clock::time_point::max();
    for (const auto& [study, kinds] : kept_)
      for (const auto& [kind, kept] : kinds) {
        bytes += kept.surface->bytes();
        oldest = std::min(oldest, kept.used);
        ++count;
      }
    if (bytes <= most_bytes || count <= 1) return;
    for (auto& [study, kinds] : kept_)
      std::erase_if(kinds, [&](const auto& entry) { return entry.second.used == oldest; });
  }
}

v1::Spread Predictions::spread(const StudyRecord& study, int succeeded, bool running,
                               const std::string& monitor,
                               const std::function<std::vector<EvaluatedRun>()>& runs) {
  if (study.request.sweep().design() != v1::SweepPlan::LATIN_HYPERCUBE)
    throw CannotPredict("study " + study.id +
                        " is no Latin hypercube: its runs do not stand for what its keys may be");
  const auto keys = keys_of(study);
  const auto surface = surface_of({study, succeeded, running, ""}, [&] {
    return std::make_shared<const SweepSurface>(study, keys->all, "", runs());
  });
  const v1::Plausibility& limits = study.request.case_().plausibility();
  std::optional<CurlBand> band;
  if (limits.has_least_curl_m() || limits.has_greatest_curl_m())
    band = CurlBand{limits.has_least_curl_m() ? limits.least_curl_m() : -1e9,
                    limits.has_greatest_curl_m() ? limits.greatest_curl_m() : 1e9};
  v1::Spread spread = surface->surface().spread(monitor, band);
  if (spread.time_s().empty())
    throw CannotPredict("\"" + monitor + "\" is no monitor of this study that all runs report");
  return spread;
}

v1::Prediction Predictions::predict(const StudyRecord& study, int succeeded, bool running,
                                    const v1::PredictStudyRequest& request,
                                    const std::function<std::vector<EvaluatedRun>()>& runs) {
  if (!study.request.has_sweep())
    throw CannotPredict("study " + study.id + " is no sweep: nothing lies between its runs");
  require_design(study);
  const auto keys = keys_of(study);
  const Place place = place_of(keys->base, keys->all, request);
  const auto surface = surface_of({study, succeeded, running, place.kind}, [&] {
    return std::make_shared<const SweepSurface>(study, keys->all, place.kind, runs());
  });
  return surface->predict(place.inputs);
}

void Predictions::prepare(const StudyRecord& study, int succeeded, bool running,
                          const std::function<std::vector<EvaluatedRun>()>& runs) {
  {
    const std::lock_guard lock(mutex_);
    int& before = prepared_[study.id];
    if (succeeded == before) return;
    if (running && succeeded < std::max(fewest_prepared, 2 * before)) return;
    before = succeeded;
  }
  const auto keys = keys_of(study);
  const auto evaluated = runs();
  for (const std::string& kind : kinds_of(keys->all, evaluated)) {
    try {
      surface_of({study, succeeded, running, kind}, [&] {
        return std::make_shared<const SweepSurface>(study, keys->all, kind, evaluated);
      });
    } catch (const CannotPredict&) {
      // Reported to the caller who asks for it.
    }
  }
}

void Predictions::forget(const std::string& study) {
  const std::lock_guard lock(mutex_);
  kept_.erase(study);
  keys_.erase(study);
  prepared_.erase(study);
}

}  // namespace dccast::studies
