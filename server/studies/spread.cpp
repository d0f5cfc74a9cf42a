#include "server/studies/spread.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/statistics/sampling.hpp"

namespace dccast::studies {

namespace {

constexpr int castings = 4096;       // drawn for the quantiles
constexpr int index_samples = 2048;  // a few percent of sampling error, a second of processor time
constexpr std::size_t most_index_instants = 12;
constexpr std::uint64_t seed = 20;

/// (casting, instant) curls that the inputs and the error of the function make.
Eigen::MatrixXd drawn(const SampledCurls& sampled, int inputs) {
  const auto places = statistics::latin_hypercube(castings, inputs + 2, seed);
  Eigen::MatrixXd at(castings, inputs);
  Eigen::VectorXd normal(castings);
  for (int i = 0; i < castings; ++i) {
    const std::vector<double>& place = places[static_cast<std::size_t>(i)];
    for (int j = 0; j < inputs; ++j) at(i, j) = place[static_cast<std::size_t>(j)];
    // Box and Muller 1958.
    const double radius = std::sqrt(-2.0 * std::log(place[static_cast<std::size_t>(inputs)]));
    normal(i) = radius * std::cos(2.0 * std::numbers::pi * place.back());
  }
  Eigen::MatrixXd curls = sampled.curls(at);
  for (Eigen::Index t = 0; t < curls.cols(); ++t)
    curls.col(t) += sampled.error_m[static_cast<std::size_t>(t)] * normal;
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

/// At most so many of the instants, the last one among them.
std::vector<Eigen::Index> index_instants(std::size_t count) {
  std::vector<Eigen::Index> chosen;
  const std::size_t most = std::min(count, most_index_instants);
  for (std::size_t i = 1; i <= most; ++i)
    chosen.push_back(static_cast<Eigen::Index>(i * count / most) - 1);
  return chosen;
}

void add_shares(const SampledCurls& sampled, int inputs, v1::Spread& spread) {
  const auto instants = index_instants(sampled.time_s.size());
  const auto indices = statistics::sobol_indices(
      [&](const Eigen::MatrixXd& places) {
        return Eigen::MatrixXd(sampled.curls(places)(Eigen::all, instants));
      },
      inputs, index_samples, seed);
  for (const Eigen::Index instant : instants)
    spread.add_index_time_s(sampled.time_s[static_cast<std::size_t>(instant)]);
  v1::Spread::Share unexplained;
  Eigen::VectorXd followed(indices.variance.size());  // share of the variance that the inputs make
  for (Eigen::Index k = 0; k < followed.size(); ++k) {
    const double error =
        sampled.error_m[static_cast<std::size_t>(instants[static_cast<std::size_t>(k)])];
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
