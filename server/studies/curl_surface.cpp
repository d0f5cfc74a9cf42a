#include "server/studies/curl_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace dccast::studies {

namespace {

constexpr std::size_t most_instants = 150;
constexpr Eigen::Index most_runs = 1000;  // further runs cost time and hardly improve the surface
constexpr Eigen::Index most_for_cast_length = 200;  // which depends smoothly on the recipe alone
constexpr int candidates = 200;                     // for the next run
constexpr int most_inputs_with_corners = 6;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Instants that all runs cover: those of the first run's steps, thinned, with the last one kept.
std::vector<double> common_instants(const std::vector<SurfaceRun>& runs) {
  constexpr double margin_s = 1e-6;
  double from = -std::numeric_limits<double>::infinity(), to = -from;
  for (const SurfaceRun& run : runs) {
    const auto& time_s = run.history.curves.front().time_s();
    from = std::max(from, time_s[0]);
    to = std::min(to, time_s[time_s.size() - 1]);
  }

  std::vector<double> inside;
  for (const double t : runs.front().history.curves.front().time_s())
    if (t >= from - margin_s && t <= to + margin_s) inside.push_back(t);
  if (inside.empty() || inside.back() < to - margin_s) inside.push_back(to);

  // Thin from the end, so that the last instant stays.
  std::vector<double> instants;
  const std::size_t stride = (inside.size() + most_instants - 1) / most_instants;
  for (std::size_t i = (inside.size() - 1) % stride; i < inside.size(); i += stride)
    instants.push_back(inside[i]);
  return instants;
}

/// Rows for the surface of cast lengths, which needs few runs.
Eigen::MatrixXd thin_rows(const Eigen::MatrixXd& rows) {
  return rows(statistics::spread_indices(rows.rows(), most_for_cast_length), Eigen::all);
}

/// (run, instant) curl of one monitor [m]; NaN where a run does not report it.
Eigen::MatrixXd curls_of(const std::vector<SurfaceRun>& runs, const std::string& monitor,
                         const std::vector<double>& time_s) {
  std::vector<std::vector<double>> curls;
  for (const SurfaceRun& run : runs) {
    const v1::CurlCurve* curve = run.history.curve(monitor);
    curls.push_back(curve != nullptr ? at_instants(time_s, *curve, curve->curl_m())
                                     : std::vector<double>(time_s.size(), unknown));
  }
  return statistics::stack_rows(curls);
}

/// (run, instant) cast length [m]
Eigen::MatrixXd cast_lengths_of(const std::vector<SurfaceRun>& runs,
                                const std::vector<double>& time_s) {
  std::vector<std::vector<double>> lengths;
  for (const SurfaceRun& run : runs) {
    const v1::CurlCurve& curve = run.history.curves.front();
    lengths.push_back(at_instants(time_s, curve, curve.cast_length_m()));
  }
  return statistics::stack_rows(lengths);
}

/// (place, input) in the unit cube: a spread, and the corners, where a surface is least certain.
Eigen::MatrixXd candidate_places(int inputs) {
  const Eigen::MatrixXd spread = statistics::hypercube(candidates, inputs, 1);
  if (inputs > most_inputs_with_corners) return spread;

  const int corners = 1 << inputs;
  Eigen::MatrixXd places(candidates + corners, inputs);
  places << spread,
      Eigen::MatrixXd::NullaryExpr(corners, inputs, [&](Eigen::Index corner, Eigen::Index input) {
        return static_cast<double>(corner >> (inputs - 1 - input) & 1);
      });
  return places;
}

/// Reduces the runs to as many as improve a surface. @return  number of runs kept
int keep_some(std::vector<SurfaceRun>& runs) {
  const auto chosen = statistics::spread_indices(std::ssize(runs), most_runs);
  for (Eigen::Index i = 0; i < std::ssize(chosen); ++i)
    if (chosen[i] != i) runs[i] = std::move(runs[chosen[i]]);
  runs.resize(chosen.size());
  return static_cast<int>(runs.size());
}

constexpr int castings = 4096;       // drawn for the quantiles
constexpr int index_samples = 2048;  // a few percent of sampling error, a second of processor time
constexpr std::size_t most_index_instants = 12;
constexpr std::uint64_t seed = 20;

/// (casting, instant) curls of random castings [m], with the error of the surface as normal noise.
Eigen::MatrixXd drawn(const SampledCurls& sampled, int inputs) {
  const Eigen::MatrixXd places = statistics::hypercube(castings, inputs + 2, seed);

  // Two further columns give a normal deviate of each casting (Box and Muller 1958).
  const Eigen::VectorXd normal = Eigen::VectorXd::NullaryExpr(castings, [&](Eigen::Index i) {
    const double radius = std::sqrt(-2.0 * std::log(places(i, inputs)));
    return radius * std::cos(2.0 * std::numbers::pi * places(i, inputs + 1));
  });

  Eigen::MatrixXd curls = sampled.curls(places.leftCols(inputs));
  for (Eigen::Index t = 0; t < curls.cols(); ++t) curls.col(t) += sampled.error_m[t] * normal;
  return curls;
}

void add_quantiles(Eigen::MatrixXd curls, v1::Spread& spread) {
  for (Eigen::Index t = 0; t < curls.cols(); ++t) {
    auto column = curls.col(t);
    std::sort(column.begin(), column.end());
    spread.add_low_m(statistics::quantile(column, 0.05));
    spread.add_median_m(statistics::quantile(column, 0.5));
    spread.add_high_m(statistics::quantile(column, 0.95));
  }
}

double share_inside(const Eigen::VectorXd& curls, const CurlBand& band) {
  return ((curls.array() >= band.least) && (curls.array() <= band.greatest)).cast<double>().mean();
}

/// At most most_index_instants instants, evenly spread, with the last one.
std::vector<Eigen::Index> index_instants(std::size_t count) {
  std::vector<Eigen::Index> chosen;
  const std::size_t most = std::min(count, most_index_instants);
  for (std::size_t i = 1; i <= most; ++i) chosen.push_back(i * count / most - 1);
  return chosen;
}

/// Adds the Sobol indices of the inputs and, last, the share that the surface leaves unexplained.
void add_shares(const SampledCurls& sampled, int inputs, v1::Spread& spread) {
  const auto instants = index_instants(sampled.time_s.size());
  const auto indices = statistics::sobol_indices(
      [&](const Eigen::MatrixXd& places) {
        return Eigen::MatrixXd(sampled.curls(places)(Eigen::all, instants));
      },
      inputs, index_samples, seed);
  for (const Eigen::Index instant : instants) spread.add_index_time_s(sampled.time_s[instant]);

  // The error of the surface adds variance that no input explains: scale the indices down by it.
  v1::Spread::Share unexplained;
  Eigen::VectorXd followed(indices.variance.size());  // share of the variance due to inputs
  for (Eigen::Index k = 0; k < followed.size(); ++k) {
    const double error = sampled.error_m[instants[k]];
    const double whole = indices.variance(k) + error * error;
    followed(k) = whole > 0.0 ? indices.variance(k) / whole : 0.0;
    unexplained.add_first(1.0 - followed(k));
    unexplained.add_total(1.0 - followed(k));
    unexplained.add_first_error(0.0);
    unexplained.add_total_error(0.0);
  }

  for (int j = 0; j < inputs; ++j) {
    v1::Spread::Share& share = *spread.add_shares();
    for (Eigen::Index k = 0; k < followed.size(); ++k) {
      share.add_first(followed(k) * indices.first(j, k));
      share.add_total(followed(k) * indices.total(j, k));
      share.add_first_error(followed(k) * indices.first_error(j, k));
      share.add_total_error(followed(k) * indices.total_error(j, k));
    }
  }
  *spread.add_shares() = std::move(unexplained);
}

}  // namespace

CurlSurface::CurlSurface(std::vector<InputRange> domain, std::vector<SurfaceRun> runs,
                         std::vector<std::string> monitors)
    : domain_(std::move(domain)),
      runs_(keep_some(runs)),
      monitors_(std::move(monitors)),
      time_s_(common_instants(runs)),
      places_(scaled_places(runs)),
      curls_(places_, curl_figures(runs)),
      lengths_(thin_rows(places_), thin_rows(cast_lengths_of(runs, time_s_))) {
  // The error is that of leave-one-out predictions of the final curl, at the worst monitor.
  std::vector<Eigen::Index> ends;
  for (const auto& figure : figure_)
    if (figure.back() >= 0) ends.push_back(figure.back());
  for (const Eigen::Index end : ends)
    error_m_ = std::max(error_m_, curls_.left_out_errors(end).norm() / std::sqrt(runs_));

  // The next run belongs where the final curls are least certain.
  const Eigen::MatrixXd places = candidate_places(static_cast<int>(domain_.size()));
  Eigen::Index widest = 0;
  curls_.summed_variance(places, ends).maxCoeff(&widest);
  for (Eigen::Index j = 0; j < places.cols(); ++j) next_place_.push_back(places(widest, j));
}

std::vector<v1::CurlCurve> CurlSurface::predict(const std::vector<double>& place) const {
  const Eigen::RowVectorXd row = scaled(place);
  const auto curls = curls_.estimate(row);
  const auto lengths = lengths_.estimate(row);

  std::vector<v1::CurlCurve> curves(monitors_.size());
  for (std::size_t m = 0; m < monitors_.size(); ++m) {
    curves[m].set_monitor(monitors_[m]);
    for (std::size_t i = 0; i < time_s_.size(); ++i) {
      const Eigen::Index figure = figure_[m][i];
      curves[m].add_time_s(time_s_[i]);
      curves[m].add_cast_length_m(lengths.mean(i));
      curves[m].add_curl_m(figure < 0 ? unknown : curls.mean(figure));
      curves[m].add_uncertainty_m(figure < 0 ? unknown : std::sqrt(curls.variance(figure)));
    }
  }
  return curves;
}

v1::Spread CurlSurface::spread(const std::string& monitor,
                               const std::optional<CurlBand>& band) const {
  const auto m = std::ranges::find(monitors_, monitor) - monitors_.begin();
  if (m == std::ssize(monitors_)) return {};

  // Instants at which every run reports the monitor, with the cast length at the centre of the
  // domain.
  SampledCurls sampled;
  std::vector<Eigen::Index> figures;
  const auto lengths = lengths_.estimate(Eigen::RowVectorXd::Constant(places_.cols(), 0.5));
  for (std::size_t i = 0; i < time_s_.size(); ++i) {
    const Eigen::Index figure = figure_[m][i];
    if (figure < 0) continue;
    figures.push_back(figure);
    sampled.time_s.push_back(time_s_[i]);
    sampled.cast_length_m.push_back(lengths.mean(i));
    sampled.error_m.push_back(curls_.left_out_errors(figure).norm() / std::sqrt(runs_));
  }

  sampled.curls = [&](const Eigen::MatrixXd& places) {
    return Eigen::MatrixXd(curls_.means(places)(Eigen::all, figures));
  };

  v1::Spread spread = spread_of(sampled, static_cast<int>(domain_.size()), band);
  spread.set_monitor(monitor);
  spread.set_runs(runs_);
  return spread;
}

Eigen::RowVectorXd CurlSurface::scaled(const std::vector<double>& place) const {
  Eigen::RowVectorXd row(place.size());
  for (std::size_t j = 0; j < place.size(); ++j) {
    const double width = domain_[j].high - domain_[j].low;
    row(j) = width > 0.0 ? (place[j] - domain_[j].low) / width : 0.0;
  }
  return row;
}

Eigen::MatrixXd CurlSurface::scaled_places(const std::vector<SurfaceRun>& runs) const {
  Eigen::MatrixXd places(runs.size(), domain_.size());
  for (std::size_t i = 0; i < runs.size(); ++i) places.row(i) = scaled(runs[i].place);
  return places;
}

/// (run, figure) curls of all monitors at the instants at which every run reports them; fills
/// figure_.
Eigen::MatrixXd CurlSurface::curl_figures(const std::vector<SurfaceRun>& runs) {
  std::vector<Eigen::VectorXd> columns;
  for (const std::string& monitor : monitors_) {
    const Eigen::MatrixXd curls = curls_of(runs, monitor, time_s_);
    auto& figure = figure_.emplace_back(time_s_.size(), -1);
    for (Eigen::Index i = 0; i < curls.cols(); ++i) {
      if (!curls.col(i).allFinite()) continue;
      figure[i] = columns.size();
      columns.push_back(curls.col(i));
    }
  }

  Eigen::MatrixXd figures(runs.size(), columns.size());
  for (std::size_t k = 0; k < columns.size(); ++k) figures.col(k) = columns[k];
  return figures;
}

v1::Spread spread_of(const SampledCurls& sampled, int inputs, const std::optional<CurlBand>& band) {
  v1::Spread spread;
  if (sampled.time_s.empty()) return spread;
  *spread.mutable_time_s() = {sampled.time_s.begin(), sampled.time_s.end()};
  *spread.mutable_cast_length_m() = {sampled.cast_length_m.begin(), sampled.cast_length_m.end()};
  *spread.mutable_surface_error_m() = {sampled.error_m.begin(), sampled.error_m.end()};

  const Eigen::MatrixXd curls = drawn(sampled, inputs);
  if (band) spread.set_inside_band(share_inside(curls.rightCols<1>(), *band));
  add_quantiles(curls, spread);
  add_shares(sampled, inputs, spread);
  return spread;
}

}  // namespace dccast::studies
