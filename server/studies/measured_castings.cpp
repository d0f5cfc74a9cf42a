// Measured curves on the response surfaces of castings: from runs and readings to what
// statistics::calibrate() takes, and back to keys, bands and places of further runs.
#include "server/studies/measured_castings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>

#include "core/statistics/calibration.hpp"
#include "core/statistics/sampling.hpp"
#include "proto/case_file/study_keys.hpp"
#include "server/studies/curl_surface.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

namespace {

constexpr int drawn_before = 1000;  // castings, for the band before
constexpr std::uint64_t seed = 20;
constexpr double half_of_band = 1.645;  // standard deviations: a band covers 9 of 10
constexpr double least_curl_m = 1e-3;   // scales: what is less is not looked for
constexpr double least_temperature_k = 10.0;
// Root mean squares of a few runs scatter; a surface that is off by more than this does not hold.
constexpr double confirmed_ratio = 2.0;

/// A measured curve, ready to calibrate with.
struct Channel {
  int casting = 0;
  v1::MeasuredCurve measured, used;
  Computed computed;
  std::unique_ptr<CurveSurface> surface;
};

/// The axes of all castings.
std::vector<InputRange> ranges_of(const v1::CreateStudyRequest& request) {
  std::vector<InputRange> ranges;
  for (const auto& axis : request.sweep().axes()) {
    const auto& range =
        ranges.emplace_back(InputRange{number_of(request.case_(), axis.key(), axis.values(0)),
                                       number_of(request.case_(), axis.key(), axis.values(1))});
    if (!std::isfinite(range.low) || !std::isfinite(range.high))
      throw CannotPredict(axis.key() + " is no number, which a calibration needs");
  }
  return ranges;
}

/// (run, axis) places of runs, 0 to 1.
Eigen::MatrixXd places_of(const std::vector<EvaluatedRun>& runs,
                          const std::vector<InputRange>& ranges) {
  Eigen::MatrixXd places(runs.size(), ranges.size());
  for (std::size_t i = 0; i < runs.size(); ++i)
    for (int j = 0; j < std::ssize(ranges); ++j)
      places(i, j) = (runs[i].run.numbers(j) - ranges[j].low) / (ranges[j].high - ranges[j].low);
  return places;
}

/// A place on an axis as in a case file.
std::string text_of(const v1::CreateStudyRequest& request, int axis, double place) {
  const v1::SweepPlan::Axis& ends = request.sweep().axes(axis);
  return value_between(request.case_(), ends.key(), ends.values(0), ends.values(1), place);
}

void require_same_axes(const std::vector<MeasuredCasting>& castings) {
  const auto same = [](const auto& a, const auto& b) {
    return a.SerializeAsString() == b.SerializeAsString();
  };
  for (const MeasuredCasting& casting : castings)
    if (!std::ranges::equal(casting.request.sweep().axes(), castings.front().request.sweep().axes(),
                            same))
      throw CannotPredict("the castings have different free keys or ranges");
}

/// Keeps the runs that can be learned from.
void keep_valid(MeasuredCasting& casting, std::size_t inputs) {
  const auto from_last = casting.runs.end() - casting.last;
  casting.last = static_cast<int>(
      std::count_if(from_last, casting.runs.end(), [](const auto& run) { return run.counts(); }));
  std::erase_if(casting.runs, [](const EvaluatedRun& run) { return !run.counts(); });
  const std::size_t fewest = CurlSurface::fewest_runs(inputs);
  if (casting.runs.size() - casting.last < fewest)
    throw CannotPredict(
        fmt::format("a calibration over {} keys needs {} valid runs that succeeded, and {} have",
                    inputs, fewest, casting.runs.size()));
}

/// The unit of noise and misfit: root mean square of curls, or of temperatures about their mean.
double scale_of(const std::vector<Channel>& channels, bool curl) {
  double sum = 0.0, count = 0.0;
  for (const Channel& channel : channels) {
    if (is_curl(channel.measured) != curl) continue;
    const auto& values = values_of(channel.used);
    const double mean =
        curl ? 0.0 : std::accumulate(values.begin(), values.end(), 0.0) / values.size();
    for (const double value : values) sum += (value - mean) * (value - mean), count += 1.0;
  }
  return std::max(std::sqrt(sum / std::max(count, 1.0)), curl ? least_curl_m : least_temperature_k);
}

Eigen::VectorXd column_of(const google::protobuf::RepeatedField<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), values.size());
}

statistics::CalibrationDraws infer(const std::vector<Channel>& channels, int inputs,
                                   double mesh_error) {
  // Quantity 0 is curl and 1 is temperature; both exist even if only one was measured.
  const std::vector<statistics::Quantity> quantities{
      {scale_of(channels, true), mesh_error / half_of_band}, {scale_of(channels, false), 0.0}};

  std::vector<statistics::Readings> readings;
  for (const Channel& channel : channels) {
    auto& curve = readings.emplace_back();
    curve.at = column_of(channel.used.time_s());
    curve.values = column_of(values_of(channel.used));
    curve.model_covariance = channel.surface->covariance();
    if (channel.measured.noise() > 0.0) curve.noise = channel.measured.noise();
    curve.quantity = is_curl(channel.measured) ? 0 : 1;
  }

  // (casting, reading) values of each channel's surface at given places of the inputs.
  const auto model = [&](const Eigen::MatrixXd& places) {
    std::vector<Eigen::MatrixXd> curves;
    for (const Channel& channel : channels)
      curves.push_back(channel.surface->means(places).leftCols(channel.surface->readings()));
    return curves;
  };

  return statistics::calibrate(model, inputs, readings, quantities, seed);
}

/// Quantiles 5, 50 and 95 % of draws.
v1::Calibration::Share share_of(Eigen::VectorXd draws) {
  std::sort(draws.begin(), draws.end());
  v1::Calibration::Share share;
  share.set_low(statistics::quantile(draws, 0.05));
  share.set_median(statistics::quantile(draws, 0.5));
  share.set_high(statistics::quantile(draws, 0.95));
  return share;
}

/// Quantiles of curves over castings; the error of the surface is added as normal noise.
v1::Calibration::Band band_of(Eigen::MatrixXd curves, const Eigen::RowVectorXd& error) {
  std::mt19937_64 random(seed);
  for (Eigen::Index i = 0; i < curves.rows(); ++i)
    curves.row(i) += statistics::normal(random) * error;

  v1::Calibration::Band band;
  for (Eigen::Index k = 0; k < curves.cols(); ++k) {
    const auto share = share_of(curves.col(k));
    band.add_low(share.low());
    band.add_median(share.median());
    band.add_high(share.high());
  }
  return band;
}

/// Root mean square difference of the readings from a computed curve.
double rms_difference(const Channel& channel, const Eigen::MatrixXd& computed) {
  const Eigen::RowVectorXd values = column_of(values_of(channel.used)).transpose();
  return (values - computed).norm() / std::sqrt(static_cast<double>(values.size()));
}

/// Result of one measured curve: bands before and after calibration, best curve, misfit and noise.
/// @param best  index of the central draw
v1::Calibration::Curve curve_of(const Channel& channel, const statistics::CalibrationDraws& draws,
                                Eigen::Index best) {
  const CurveSurface& surface = *channel.surface;
  const int quantity = is_curl(channel.measured) ? 0 : 1;

  v1::Calibration::Curve curve;

  curve.set_casting(channel.casting);
  *curve.mutable_measured() = channel.used;
  curve.set_readings(values_of(channel.measured).size());
  *curve.mutable_time_s() = {channel.computed.time_s.begin(), channel.computed.time_s.end()};
  *curve.mutable_cast_length_m() = {channel.computed.cast_length_m.begin(),
                                    channel.computed.cast_length_m.end()};

  // Before the calibration the inputs fill their ranges; after it they follow the draws.
  const int inputs = static_cast<int>(draws.inputs.cols());
  const Eigen::MatrixXd before = surface.means(statistics::hypercube(drawn_before, inputs, seed));
  const Eigen::MatrixXd after = surface.means(draws.inputs);
  *curve.mutable_before() = band_of(before.rightCols(band_instants), surface.error());
  *curve.mutable_after() = band_of(after.rightCols(band_instants), surface.error());

  const Eigen::RowVectorXd at_best = after.row(best);
  for (int i = 0; i < band_instants; ++i) curve.add_best(at_best(surface.readings() + i));

  curve.set_surface_error(surface.error_at_readings());
  curve.set_off_before(
      rms_difference(channel, before.leftCols(surface.readings()).colwise().mean()));
  curve.set_off_after(rms_difference(channel, at_best.head(surface.readings())));

  // A noise given with the measurement is not inferred.
  const double noise = channel.measured.noise();
  *curve.mutable_noise() = share_of(noise > 0.0 ? Eigen::VectorXd::Constant(1, noise)
                                                : draws.noise.col(quantity).eval());
  *curve.mutable_misfit() = share_of(draws.misfit.col(quantity));
  return curve;
}

/// Adds the difference of the last further runs from a surface that is built without them.
/// @param places  (run, input)  @param last  number of further runs
void add_check(const Channel& channel, const Eigen::MatrixXd& places, int last,
               v1::Calibration::Curve& curve) {
  const Eigen::Index before = places.rows() - last;
  Computed known = channel.computed;

  known.runs.resize(before);

  const CurveSurface surface(places.topRows(before), known, channel.used);
  const Eigen::MatrixXd truth = CurveSurface::figures(channel.computed, channel.used)
                                    .bottomRows(last)
                                    .leftCols(surface.readings());

  const Eigen::MatrixXd off =
      surface.means(places.bottomRows(last)).leftCols(surface.readings()) - truth;
  curve.set_check_error(off.norm() / std::sqrt(static_cast<double>(off.size())));
  curve.set_checked_error(surface.error_at_readings());
  curve.set_is_confirmed(curve.check_error() <=
                         std::max(confirmed_ratio * curve.checked_error(), curve.noise().median()));
}

/// Adds for each calibrated key its quantiles, its best value and its correlations.
void add_keys(const v1::CreateStudyRequest& request, const Eigen::MatrixXd& inputs,
              Eigen::Index best, v1::Calibration& calibration) {
  const Eigen::MatrixXd correlation = statistics::correlations(inputs);
  for (int j = 0; j < inputs.cols(); ++j) {
    v1::Calibration::Key& key = *calibration.add_keys();
    key.set_key(request.sweep().axes(j).key());
    key.set_unit(case_file::unit_of_change(key.key()));
    const auto share = share_of(inputs.col(j));
    key.set_low(share.low());
    key.set_median(share.median());
    key.set_high(share.high());
    key.set_best(inputs(best, j));

    key.set_low_text(text_of(request, j, key.low()));
    key.set_median_text(text_of(request, j, key.median()));
    key.set_high_text(text_of(request, j, key.high()));
    key.set_best_text(text_of(request, j, key.best()));

    // 0.9 is the width of the same quantiles before calibration, where the key is uniform.
    key.set_narrowed((share.high() - share.low()) / 0.9);
    for (const double value : correlation.row(j)) key.add_correlation(value);
  }
}

/// Adds places for further runs that test the calibration: the best draw and some along its ridge.
void add_checks(const v1::CreateStudyRequest& request, const Eigen::MatrixXd& inputs,
                Eigen::Index best, v1::Calibration& calibration) {
  auto draws = statistics::draws_along_ridge(inputs, {0.05, 0.35, 0.65, 0.95});
  draws.insert(draws.begin(), best);
  for (const Eigen::Index draw : draws) {
    v1::Calibration::Place& place = *calibration.add_checks();
    for (int j = 0; j < inputs.cols(); ++j) place.add_values(text_of(request, j, inputs(draw, j)));
  }
}

}  // namespace

v1::Calibration calibration_of(std::vector<MeasuredCasting> castings) {
  require_same_axes(castings);
  const v1::CreateStudyRequest first = castings.front().request;
  const std::vector<InputRange> ranges = ranges_of(first);

  // One channel for each measured curve of each casting, with a surface of that casting's runs.
  v1::Calibration calibration;
  std::vector<Channel> channels;
  std::vector<Eigen::MatrixXd> places;
  bool known = true;
  double largest_error = 0.0;
  for (MeasuredCasting& casting : castings) {
    keep_valid(casting, ranges.size());
    // The inference takes the band as its scale, on both sides.
    const auto error = mesh_error(casting.request.case_());
    known = known && error;
    if (error) largest_error = std::max({largest_error, error->lower(), error->upper()});
    calibration.add_runs(static_cast<int>(casting.runs.size()));
    const Eigen::MatrixXd& here = places.emplace_back(places_of(casting.runs, ranges));

    for (const v1::MeasuredCurve& measured : casting.request.sweep().measured()) {
      Channel& channel = channels.emplace_back();
      channel.casting = static_cast<int>(places.size()) - 1;
      channel.measured = measured;
      channel.computed = computed_of(casting.runs, measured);
      channel.used = usable(measured, channel.computed);
      channel.surface = std::make_unique<CurveSurface>(here, channel.computed, channel.used);
    }
  }
  if (channels.empty()) throw CannotPredict("nothing was measured of these castings");

  const auto draws = infer(channels, static_cast<int>(ranges.size()), largest_error);
  const Eigen::Index best = statistics::central_draw(draws.inputs);

  add_keys(first, draws.inputs, best, calibration);
  add_checks(first, draws.inputs, best, calibration);
  calibration.set_fixed(statistics::fixed_combinations(draws.inputs));

  for (const Channel& channel : channels) {
    v1::Calibration::Curve& curve = *calibration.add_curves() = curve_of(channel, draws, best);
    const int last = castings[channel.casting].last;
    if (last > 0) add_check(channel, places[channel.casting], last, curve);
  }

  // The error of the mesh is common to all curls, if it is known for every casting.
  if (known) {
    calibration.set_mesh_error(largest_error);
    *calibration.mutable_mesh_factor() = share_of(draws.common);
  }
  return calibration;
}

}  // namespace dccast::studies
