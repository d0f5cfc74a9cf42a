#include "server/studies/sweep_surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schema.hpp"
#include "proto/case_file/text_checks.hpp"
#include "server/jobs/log.hpp"
#include "server/studies/curl_surface.hpp"

namespace dccast::studies {

/// The response surface of the runs of one kind.
struct SweepSurface {
  CurlSurface surface;
  std::vector<v1::CaseChange> next_run;         ///< place where the surface is least certain
  std::optional<v1::RelativeError> mesh_error;  ///< largest of the runs; empty if one is unknown
};

namespace {

// While runs arrive, a surface is rebuilt so rarely that building takes at most one part in
// building_share of the time; it may be out of date until then.
constexpr int building_share = 20;
// A sweep over alloys has a surface for each; those beyond this number are built on request.
constexpr std::size_t most_prepared = 8;
constexpr int fewest_prepared = 16;  // runs; a surface of fewer takes no noticeable time
constexpr std::size_t most_bytes = 256'000'000;  // memory of all kept surfaces
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// One axis of a sweep: numbers are inputs of surfaces, other values select a surface.
struct SweptKey {
  std::string key;
  bool numeric = true;
  InputRange range;                 ///< of a numeric key, in the unit of the schema
  std::string low, high;            ///< the ends of the range as written
  std::vector<std::string> values;  ///< of any key, as written
};

SweptKey swept_key(const v1::Case& base, const v1::SweepPlan::Axis& axis) {
  SweptKey key{axis.key(), true, {}, {}, {}, {axis.values().begin(), axis.values().end()}};
  for (const std::string& value : key.values) {
    const double number = number_of(base, axis.key(), value);
    key.numeric = key.numeric && std::isfinite(number);
    if (key.low.empty() || number < key.range.low) {
      key.low = value;
      key.range.low = number;
    }
    if (key.high.empty() || number > key.range.high) {
      key.high = value;
      key.range.high = number;
    }
  }
  return key;
}

/// Place of a prediction.
struct Place {
  std::vector<double> inputs;  ///< values of the numeric keys
  std::string kind;            ///< values of the other keys
};

[[noreturn]] void outside(const SweptKey& key, const std::string& value) {
  throw OutsideDomain(fmt::format(
      "{} = {} is outside of what the study has run; permitted: {}", key.key, value,
      key.numeric ? fmt::format("{} to {}", key.low, key.high) : case_file::joined(key.values)));
}

/// Value of a numeric key for a prediction. @param given  value of the request; null: the case's
double input_of(const v1::Case& base, const SweptKey& key, const std::string* given) {
  constexpr double margin = 1e-9;  // relative; units may have been converted
  const double number = given != nullptr ? number_of(base, key.key, *given)
                                         : case_file::number_at(base, key.key).value_or(unknown);

  if (given != nullptr && !std::isfinite(number))
    throw FaultyPlace(fmt::format("{} = {} cannot be read; permitted: {} to {}", key.key, *given,
                                  key.low, key.high));
  if (given == nullptr && !std::isfinite(number))
    throw FaultyPlace(fmt::format("give a value of {}, {} to {}: the case has none of its own",
                                  key.key, key.low, key.high));

  const double allowed = margin * std::max(std::abs(key.range.low), std::abs(key.range.high));
  if (number < key.range.low - allowed || number > key.range.high + allowed)
    outside(key, given != nullptr ? *given : "as in the case, which is not given");
  return number;
}

[[noreturn]] void not_swept(const std::string& key, const std::vector<SweptKey>& keys) {
  std::vector<std::string> names;
  for (const SweptKey& swept : keys) names.push_back(swept.key);
  const std::string near = case_file::nearest(key, names);
  throw FaultyPlace(fmt::format("{} was not swept; {}the keys of this study are {}", key,
                                near.empty() ? "" : fmt::format("did you mean {}? ", near),
                                case_file::joined(names)));
}

/// Place that a request names. @throws FaultyPlace, OutsideDomain
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
        throw FaultyPlace(
            fmt::format("give a value of {}: {}", key.key, case_file::joined(key.values)));
      if (std::ranges::find(key.values, *value) == key.values.end()) outside(key, *value);
      place.kind += *value + "\n";
    }
  }
  return place;
}

/// Values of a run's keys that are not numbers.
std::string kind_of(const std::vector<SweptKey>& keys, const EvaluatedRun& run) {
  std::string kind;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (!keys[i].numeric) kind += run.run.values(static_cast<int>(i)) + "\n";
  return kind;
}

void require_runs(std::size_t inputs, std::size_t runs) {
  const std::size_t fewest = CurlSurface::fewest_runs(inputs);
  if (inputs == 0) throw CannotPredict("no key of this study has numbers to interpolate");
  if (runs < fewest)
    throw CannotPredict(
        fmt::format("a prediction over {} keys needs {} valid runs that succeeded, and {} have; "
                    "wait for more, or sweep more",
                    inputs, fewest, runs));
}

/// Builds the surface of the runs of one kind. @throws CannotPredict  too few runs
SweepSurface sweep_surface(const v1::Case& base, const std::vector<SweptKey>& keys,
                           const std::string& kind, const std::vector<EvaluatedRun>& runs) {
  std::vector<SurfaceRun> chosen;
  std::optional<v1::RelativeError> largest_error = v1::RelativeError();

  for (const EvaluatedRun& run : runs) {
    if (!run.counts() || kind_of(keys, run) != kind) continue;

    std::vector<double> inputs;
    for (std::size_t i = 0; i < keys.size(); ++i)
      if (keys[i].numeric) inputs.push_back(run.run.numbers(static_cast<int>(i)));
    chosen.push_back({std::move(inputs), run.history});

    if (!run.run.has_mesh_error()) largest_error.reset();
    if (!largest_error) continue;
    largest_error->set_lower(std::max(largest_error->lower(), run.run.mesh_error().lower()));
    largest_error->set_upper(std::max(largest_error->upper(), run.run.mesh_error().upper()));
  }

  std::vector<InputRange> domain;
  for (const SweptKey& key : keys)
    if (key.numeric) domain.push_back(key.range);
  require_runs(domain.size(), chosen.size());

  std::vector<std::string> monitors;
  for (const v1::Monitor& monitor : base.monitor()) monitors.push_back(monitor.name());
  SweepSurface built{
      CurlSurface(std::move(domain), std::move(chosen), std::move(monitors)), {}, largest_error};

  auto place = built.surface.next_place().begin();
  for (const SweptKey& key : keys)
    if (key.numeric)
      built.next_run.push_back(
          case_file::change_of(key.key, value_between(base, key.key, key.low, key.high, *place++)));
  return built;
}

}  // namespace

/// The axes of a sweep, kept because reading the values of a long list takes longer than
/// predicting.
struct SweptKeys {
  v1::Case base;  ///< with defaults
  std::vector<SweptKey> keys;
};

void SweepSurfaces::start() {
  state_.surface_keeper.start([this](const std::string& id) { prepare(id); });
  constexpr int likely_asked = 5;  // of the studies in the store, the newest
  for (const StudyRecord& study : state_.store.list({.size = likely_asked}))
    state_.surface_keeper.look_at(study.id);
}

SweepSurfaces::Sweep SweepSurfaces::sweep_of(const StudyRecord& study) {
  const RunCounts counts = state_.store.counts(study.id);
  return {study, counts.of(v1::SUCCEEDED), counts.ended() < counts.all()};
}

const std::vector<EvaluatedRun>& SweepSurfaces::runs_of(Sweep& sweep) {
  if (!sweep.runs) sweep.runs = results_.evaluated_runs(sweep.study, {.histories = true});
  return *sweep.runs;
}

std::shared_ptr<const SweptKeys> SweepSurfaces::keys_of(const StudyRecord& study) {
  const std::lock_guard lock(mutex_);
  auto& kept = studies_[study.id].keys;
  if (kept != nullptr) return kept;
  SweptKeys keys{study.request.case_(), {}};
  case_file::apply_quality(keys.base);
  case_file::apply_defaults(keys.base);
  for (const auto& axis : study.request.sweep().axes())
    keys.keys.push_back(swept_key(study.request.case_(), axis));
  return kept = std::make_shared<const SweptKeys>(std::move(keys));
}

SweepSurfaces::Surface SweepSurfaces::kept_surface(const Sweep& sweep, const std::string& kind,
                                                   bool of_fewer_runs) {
  const std::lock_guard lock(mutex_);
  auto& surfaces = studies_[sweep.study.id].kept;
  const auto found = surfaces.find(kind);
  if (found == surfaces.end()) return nullptr;
  CachedSurface& kept = found->second;
  kept.used = Clock::now();
  const bool recent = sweep.running && kept.used - kept.built < building_share * kept.took;
  return kept.succeeded == sweep.succeeded || recent || of_fewer_runs ? kept.surface : nullptr;
}

SweepSurfaces::Surface SweepSurfaces::surface_of(Sweep& sweep, const std::string& kind) {
  if (auto surface = kept_surface(sweep, kind)) return surface;
  std::unique_lock one_at_a_time(building_, std::try_to_lock);
  if (!one_at_a_time) {
    // While runs arrive, an answer from fewer runs now is worth more than a better one later. The
    // prediction states the number of its runs.
    if (auto older = sweep.running ? kept_surface(sweep, kind, true) : nullptr) return older;
    one_at_a_time.lock();
  }
  // Another thread may have built it while this one waited.
  if (auto surface = kept_surface(sweep, kind)) return surface;

  const auto begin = Clock::now();
  const auto surface = std::make_shared<const SweepSurface>(
      sweep_surface(sweep.study.request.case_(), keys_of(sweep.study)->keys, kind, runs_of(sweep)));
  const auto now = Clock::now();
  log::debug("study {}: response surface of {} runs in {} ms", sweep.study.id, sweep.succeeded,
             std::chrono::duration_cast<std::chrono::milliseconds>(now - begin).count());

  const std::lock_guard lock(mutex_);
  studies_[sweep.study.id].kept[kind] = {surface, sweep.succeeded, now, now - begin, now};
  make_room();
  return surface;
}

void SweepSurfaces::make_room() {
  for (;;) {
    std::size_t bytes = 0, count = 0;
    auto oldest = Clock::time_point::max();
    for (const auto& [id, study] : studies_)
      for (const auto& [kind, kept] : study.kept) {
        bytes += kept.surface->surface.bytes();
        oldest = std::min(oldest, kept.used);
        ++count;
      }
    if (bytes <= most_bytes || count <= 1) return;

    for (auto& [id, study] : studies_)
      std::erase_if(study.kept, [&](const auto& entry) { return entry.second.used == oldest; });
  }
}

v1::Spread SweepSurfaces::spread(const StudyRecord& study, const std::string& monitor) {
  const v1::CreateStudyRequest& request = study.request;
  if (request.sweep().design() != v1::SweepPlan::LATIN_HYPERCUBE)
    throw CannotPredict(fmt::format(
        "study {} is not a Latin hypercube: its runs do not cover the ranges of its keys",
        study.id));

  // A limit that is not given does not bind.
  const v1::Plausibility& limits = request.case_().plausibility();
  std::optional<CurlBand> band;
  if (limits.has_least_curl_m() || limits.has_greatest_curl_m())
    band = CurlBand{limits.has_least_curl_m() ? limits.least_curl_m() : -1e9,
                    limits.has_greatest_curl_m() ? limits.greatest_curl_m() : 1e9};

  Sweep sweep = sweep_of(study);
  v1::Spread spread = surface_of(sweep, "")->surface.spread(monitor, band);
  if (spread.time_s().empty())
    throw CannotPredict(
        fmt::format("\"{}\" is no monitor of this study that all runs report", monitor));
  return spread;
}

std::optional<v1::Prediction> SweepSurfaces::predict(const v1::PredictStudyRequest& request) {
  const auto study = state_.store.find(request.id());
  if (!study) return std::nullopt;
  if (!study->request.has_sweep())
    throw CannotPredict("study " + study->id + " is no sweep: nothing lies between its runs");

  // Runs that vary one key each show nothing of two keys together.
  if (study->request.sweep().design() == v1::SweepPlan::ENDS)
    throw CannotPredict(
        "study " + study->id +
        " changes one key at a time; dccast sweep --lhs makes runs to predict from");

  Sweep sweep = sweep_of(*study);
  const auto keys = keys_of(sweep.study);
  const Place place = place_of(keys->base, keys->keys, request);
  const auto found = surface_of(sweep, place.kind);

  v1::Prediction prediction;
  for (v1::CurlCurve& curve : found->surface.predict(place.inputs))
    *prediction.add_curves() = std::move(curve);
  prediction.set_cross_validated_error_m(found->surface.cross_validated_error_m());
  prediction.set_runs(found->surface.runs());
  *prediction.mutable_next_run() = {found->next_run.begin(), found->next_run.end()};
  if (found->mesh_error) *prediction.mutable_mesh_error() = *found->mesh_error;

  std::vector<double> end_curl_m;
  for (const v1::CurlCurve& curve : prediction.curves())
    end_curl_m.push_back(curve.curl_m().empty() ? NAN : *curve.curl_m().rbegin());
  case_file::set_end_errors(keys->base, end_curl_m, prediction);
  return prediction;
}

void SweepSurfaces::prepare(const std::string& id) {
  const auto study = state_.store.find(id);
  if (!study || !study->request.has_sweep() ||
      study->request.sweep().design() == v1::SweepPlan::ENDS)
    return;

  Sweep sweep = sweep_of(*study);
  {
    const std::lock_guard lock(mutex_);
    int& before = studies_[id].prepared;
    if (sweep.succeeded == before) return;
    if (sweep.running && sweep.succeeded < std::max(fewest_prepared, 2 * before)) return;
    before = sweep.succeeded;
  }

  // Build the surface of each kind that the runs have.
  const auto keys = keys_of(sweep.study);
  std::set<std::string> kinds;
  for (const EvaluatedRun& run : runs_of(sweep))
    if (run.counts() && kinds.size() < most_prepared) kinds.insert(kind_of(keys->keys, run));
  for (const std::string& kind : kinds) {
    try {
      surface_of(sweep, kind);
    } catch (const CannotPredict&) {
      // A caller who asks for a prediction receives the reason.
    }
  }
}

void SweepSurfaces::forget(const std::string& study) {
  const std::lock_guard lock(mutex_);
  studies_.erase(study);
}

}  // namespace dccast::studies
