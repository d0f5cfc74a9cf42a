#include "server/studies/measured_castings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "core/statistics/sampling.hpp"
#include "proto/values/interpolation.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

namespace {

constexpr int most_readings = 40;     // of a curve; more are averaged
constexpr double same_length = 0.01;  // to which runs agree on the cast length

using Numbers = std::vector<double>;
using Field = google::protobuf::RepeatedField<double>;

/// The curve's name in messages.
std::string name_of(const v1::MeasuredCurve& measured) {
  return fmt::format("{} of {} ({})", is_curl(measured) ? "curl" : "temperature",
                     measured.monitor(), measured.source());
}

/// What a run computes where the curve was measured; empty if the run does not report it.
History history_of(const RunCurves& run, const v1::MeasuredCurve& measured) {
  const v1::CurlCurve* curve = run.curve(measured.monitor());
  const auto temperature_c = run.temperature_c.find(measured.monitor());
  if (curve == nullptr || (!is_curl(measured) && temperature_c == run.temperature_c.end()))
    return {};

  History history;
  for (int i = 0; i < curve->time_s_size(); ++i) {
    const double value = is_curl(measured) ? curve->curl_m(i) : temperature_c->second[i];
    if (!std::isfinite(value)) continue;
    history.time_s.push_back(curve->time_s(i));
    history.cast_length_m.push_back(curve->cast_length_m(i));
    history.value.push_back(value);
  }
  return history;
}

/// First time at which a length is cast [s]; NaN if it is never cast.
double time_at(const Computed& computed, double length_m) {
  const auto above = std::ranges::lower_bound(computed.cast_length_m, length_m);
  if (above == computed.cast_length_m.end()) return std::nan("");
  const auto i = above - computed.cast_length_m.begin();
  if (i == 0) return length_m < computed.cast_length_m[0] ? std::nan("") : computed.time_s[0];

  const double share = (length_m - computed.cast_length_m[i - 1]) /
                       (computed.cast_length_m[i] - computed.cast_length_m[i - 1]);
  return computed.time_s[i - 1] + share * (computed.time_s[i] - computed.time_s[i - 1]);
}

}  // namespace

bool is_curl(const v1::MeasuredCurve& measured) {
  return measured.curl_m_size() > 0;
}

const Field& values_of(const v1::MeasuredCurve& measured) {
  return is_curl(measured) ? measured.curl_m() : measured.temperature_c();
}

/// Curves of all runs, and the time that they have in common with the mean cast length over it.
/// @throws CannotPredict
Computed computed_of(const std::vector<EvaluatedRun>& runs, const v1::MeasuredCurve& measured) {
  Computed computed;
  double from = -1e300, to = 1e300;

  for (const EvaluatedRun& run : runs) {
    History& history = computed.runs.emplace_back(history_of(run.history, measured));
    if (history.time_s.empty()) throw CannotPredict(name_of(measured) + " is in no run");
    from = std::max(from, history.time_s.front());
    to = std::min(to, history.time_s.back());
  }

  if (!(from < to)) throw CannotPredict(name_of(measured) + ": the runs have no time in common");
  for (int i = 0; i < band_instants; ++i)
    computed.time_s.push_back(from + (to - from) * i / (band_instants - 1));

  // A reading at a cast length has one time only if all runs reach that length at that time.
  std::vector<Numbers> all_lengths;
  for (const History& run : computed.runs)
    all_lengths.push_back(values::at_instants(computed.time_s, run.time_s, run.cast_length_m));
  const Eigen::MatrixXd lengths = statistics::stack_rows(all_lengths);
  const Eigen::RowVectorXd mean = lengths.colwise().mean();
  computed.cast_length_m.assign(mean.begin(), mean.end());
  const double apart = (lengths.rowwise() - mean).cwiseAbs().maxCoeff();
  if (measured.cast_length_m_size() > 0 && apart > same_length * mean.maxCoeff())
    throw CannotPredict(
        fmt::format("{}: a free key changes the casting speed, so that readings "
                    "need a time instead of a cast length",
                    name_of(measured)));

  return computed;
}

/// The readings within the computed time, as means of neighbours if there are very many.
/// @throws CannotPredict  there is none
v1::MeasuredCurve usable(const v1::MeasuredCurve& measured, const Computed& computed) {
  std::vector<std::pair<double, double>> readings;
  for (int i = 0; i < values_of(measured).size(); ++i) {
    const double time_s = measured.time_s_size() > 0 ? measured.time_s(i)
                                                     : time_at(computed, measured.cast_length_m(i));
    if (time_s >= computed.time_s.front() && time_s <= computed.time_s.back())
      readings.emplace_back(time_s, values_of(measured)[i]);
  }

  if (readings.empty())
    throw CannotPredict(name_of(measured) + " has no reading within the computed time");

  v1::MeasuredCurve used = measured;
  for (Field* field : {used.mutable_time_s(), used.mutable_cast_length_m(), used.mutable_curl_m(),
                       used.mutable_temperature_c()})
    field->Clear();

  // Each group of neighbouring readings becomes one, their mean.
  const std::size_t count = std::min<std::size_t>(readings.size(), most_readings);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t begin = k * readings.size() / count;
    const std::size_t end = (k + 1) * readings.size() / count;
    const auto group = std::span(readings).subspan(begin, end - begin);

    double time_s = 0.0, value = 0.0;
    for (const auto& [instant, reading] : group) {
      time_s += instant / static_cast<double>(group.size());
      value += reading / static_cast<double>(group.size());
    }

    used.add_time_s(time_s);
    (is_curl(measured) ? used.mutable_curl_m() : used.mutable_temperature_c())->Add(value);
  }
  return used;
}

CurveSurface::CurveSurface(const Eigen::MatrixXd& places, const Computed& computed,
                           const v1::MeasuredCurve& used)
    : readings_(used.time_s_size()), surface_(places, figures(computed, used)) {
  at_ = Eigen::Map<const Eigen::VectorXd>(used.time_s().data(), readings_);
  errors_.resize(places.rows(), readings_ + band_instants);
  for (Eigen::Index k = 0; k < errors_.cols(); ++k) errors_.col(k) = surface_.left_out_errors(k);
  // Mean, lengths and nugget have followed the runs that are left out, too.
  const double runs = static_cast<double>(places.rows());
  errors_ *= std::sqrt(runs / std::max(1.0, runs - static_cast<double>(places.cols()) - 2.0));
}

Eigen::MatrixXd CurveSurface::figures(const Computed& computed, const v1::MeasuredCurve& used) {
  Numbers at(used.time_s().begin(), used.time_s().end());
  at.insert(at.end(), computed.time_s.begin(), computed.time_s.end());
  std::vector<Numbers> figures;
  for (const History& run : computed.runs)
    figures.push_back(values::at_instants(at, run.time_s, run.value));
  return statistics::stack_rows(figures);
}

Eigen::MatrixXd CurveSurface::covariance() const {
  const Eigen::MatrixXd at_readings = errors_.leftCols(readings_);
  const Eigen::MatrixXd sampled =
      at_readings.transpose() * at_readings / static_cast<double>(errors_.rows());
  // A few runs show no error in most directions, which does not mean that there is none.
  // Half of it is taken to be any curve of the same size, which forgets itself in a third of the
  // span and may have kinks, as histories with contact do.
  const Eigen::VectorXd size = sampled.diagonal().cwiseSqrt();
  const double length = std::max((at_(readings_ - 1) - at_(0)) / 3.0, 1e-9);
  const Eigen::ArrayXXd apart =
      (at_.replicate(1, readings_) - at_.transpose().replicate(readings_, 1)).array().abs();
  const Eigen::MatrixXd any = (size * size.transpose()).array() * (-apart / length).exp();
  return 0.5 * (sampled + any);
}

Eigen::RowVectorXd CurveSurface::error() const {
  return errors_.rightCols(band_instants).colwise().norm() /
         std::sqrt(static_cast<double>(errors_.rows()));
}

double CurveSurface::error_at_readings() const {
  return errors_.leftCols(readings_).norm() /
         std::sqrt(static_cast<double>(readings_ * errors_.rows()));
}

}  // namespace dccast::studies
