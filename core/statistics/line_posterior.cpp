#include "core/statistics/line_posterior.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/statistics/posterior.hpp"
#include "core/statistics/sampling.hpp"

namespace dccast::statistics {

namespace {

constexpr int plants_drawn = 600;
constexpr int castings_of_draw = 8;      // drawn of each plant
constexpr double wrong_castings = 0.01;  // of a record of one casting [A]
constexpr double wrong_dangers = 0.001;  // of one with a danger: few type one that did not come [A]
constexpr double least_probability = 1e-300;

/// One surface, with the spread of single castings around the plant's figure.
struct PlantSurface {
  const LineSurface* surface;
  Eigen::Index error_input;  ///< input of the error that stays
  /// The mean of a plant's castings is this line over the surface at the plant's part of the data,
  /// which bends between them.
  double intercept, slope;
  double casting_deviation;  ///< of a casting from the plant's figure
};

/// The model over standard normal inputs: the plant's parts of the data, then those of the errors.
class Plants {
public:
  Plants(const LineModel& model, std::uint64_t seed)
      : model_(model), kept_(std::sqrt(1.0 - model.scatter)) {
    std::mt19937_64 random(seed);
    inputs_ = model.inputs + static_cast<int>(model.dangers.size()) + (model.curl ? 1 : 0);
    prior_ = normal_matrix(plants_drawn, inputs_, random);
    for (const LineSurface& danger : model.dangers) dangers_.push_back(surface_of(danger, random));
    if (model.curl) curl_ = surface_of(*model.curl, random);
  }

  int inputs() const { return inputs_; }
  const Eigen::MatrixXd& prior() const { return prior_; }
  /// Of a casting from the plant's curl; 0: no curl is known.
  double curl_deviation() const { return curl_ ? curl_->casting_deviation : 0.0; }

  /// (place, danger) excess over the limit, in standard deviations of a casting: the share of the
  /// plant's castings in danger is the normal distribution of it.
  Eigen::MatrixXd excess(const Eigen::MatrixXd& places) const {
    Eigen::MatrixXd found(places.rows(), dangers_.size());
    for (std::size_t i = 0; i < dangers_.size(); ++i)
      found.col(i) = figure(dangers_[i], places) / dangers_[i].casting_deviation;
    return found;
  }
  /// (place) curl that the plant has on average; empty: not known.
  Eigen::VectorXd curl(const Eigen::MatrixXd& places) const {
    return curl_ ? figure(*curl_, places) : Eigen::VectorXd();
  }

  /// (place, input) data of a casting of each plant, 0 to 1.
  Eigen::MatrixXd cast(const Eigen::MatrixXd& places, std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    return cast(places, random);
  }

private:
  Eigen::MatrixXd cast(const Eigen::MatrixXd& places, std::mt19937_64& random) const {
    const Eigen::MatrixXd data = places.leftCols(model_.inputs);
    return (kept_ * data +
            std::sqrt(model_.scatter) * normal_matrix(data.rows(), data.cols(), random))
        .unaryExpr(&normal_below);
  }

  /// (place) the surface at the plant's part of the data.
  Eigen::VectorXd at_plant(const LineSurface& surface, const Eigen::MatrixXd& places) const {
    return surface.mean((kept_ * places.leftCols(model_.inputs)).unaryExpr(&normal_below));
  }

  /// Compares plants with castings that are drawn of each.
  PlantSurface surface_of(const LineSurface& surface, std::mt19937_64& random) {
    Eigen::MatrixXd castings(plants_drawn, castings_of_draw);
    for (auto casting : castings.colwise()) casting = surface.mean(cast(prior_, random));
    const Eigen::VectorXd means = castings.rowwise().mean();
    const double drawn_anew = (castings.colwise() - means).squaredNorm() /
                              static_cast<double>(castings.size() - means.size());

    const Eigen::VectorXd plants = at_plant(surface, prior_);
    const Eigen::VectorXd off = plants.array() - plants.mean();
    // A surface that is the same everywhere has no slope but rounding.
    const bool is_flat = off.squaredNorm() <= 1e-20 * (1.0 + plants.squaredNorm());
    const double slope = is_flat ? 1.0 : off.dot(means) / off.squaredNorm();
    const double error = surface.error * surface.error;
    return {.surface = &surface,
            .error_input = next_error_++,
            .intercept = means.mean() - slope * plants.mean(),
            .slope = slope,
            .casting_deviation = std::sqrt(drawn_anew + model_.scatter * error + 1e-12)};
  }

  Eigen::VectorXd figure(const PlantSurface& plant, const Eigen::MatrixXd& places) const {
    return plant.intercept +
           (plant.slope * at_plant(*plant.surface, places) +
            kept_ * plant.surface->error * places.col(model_.inputs + plant.error_input))
               .array();
  }

  const LineModel& model_;
  const double kept_;  ///< standard deviation of the plant's part of an input
  int inputs_ = 0;
  Eigen::Index next_error_ = 0;
  Eigen::MatrixXd prior_;  ///< (draw, input)
  std::vector<PlantSurface> dangers_;
  std::optional<PlantSurface> curl_;
};

double log_probability(double excess) {
  return std::log(std::max(normal_below(excess), least_probability));
}

/// Records that are equal, which cost one evaluation.
struct EqualRecords {
  LineRecord record;
  double number = 0.0;
  double expected = 0.0;  ///< logarithm of the mean likelihood of one of them before all records

  /// Probability that one of them is wrong as a whole: the less likely the more castings it has.
  double wrong() const {
    const bool has_danger = std::ranges::count(record.dangers, std::optional(true)) > 0;
    return (has_danger ? wrong_dangers : wrong_castings) / record.count;
  }
};

/// (place) logarithm of the likelihood of a right record.
Eigen::VectorXd right(const LineRecord& record, const Eigen::MatrixXd& excess,
                      const Eigen::VectorXd& curl, double curl_deviation) {
  Eigen::VectorXd likelihood = Eigen::VectorXd::Zero(excess.rows());
  for (Eigen::Index i = 0; i < excess.cols(); ++i) {
    if (!record.dangers[i]) continue;
    const double sign = *record.dangers[i] ? 1.0 : -1.0;
    likelihood += record.count * (sign * excess.col(i)).unaryExpr(&log_probability);
  }
  if (!record.curl || curl.size() == 0) return likelihood;

  const double deviation = std::hypot(curl_deviation, record.curl_noise);
  likelihood.array() -= 0.5 * ((curl.array() - *record.curl) / deviation).square() +
                        std::log(deviation * std::sqrt(2.0 * std::numbers::pi));
  return likelihood;
}

/// Logarithm of a sum of two numbers that are given by their logarithms.
double log_sum(double a, double b) {
  return std::max(a, b) + std::log1p(std::exp(-std::abs(a - b)));
}

/// What records say of plants.
class Evidence {
public:
  Evidence(const Plants& plants, const std::vector<LineRecord>& records) : plants_(plants) {
    for (const LineRecord& record : records) {
      const auto kind = static_cast<std::size_t>(
          std::ranges::find(kinds_, record, &EqualRecords::record) - kinds_.begin());
      if (kind == kinds_.size()) kinds_.push_back({record});
      kinds_[kind].number += 1.0;
      kind_of_.push_back(kind);
    }
    for (EqualRecords& kind : kinds_) {
      const Eigen::VectorXd likelihood = right_at(plants.prior(), kind.record);
      kind.expected = likelihood.maxCoeff() +
                      std::log((likelihood.array() - likelihood.maxCoeff()).exp().mean());
    }
  }

  Eigen::VectorXd log_likelihood(const Eigen::MatrixXd& places) const {
    const Eigen::MatrixXd excess = plants_.excess(places);
    const Eigen::VectorXd curl = plants_.curl(places);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(places.rows());
    for (const EqualRecords& kind : kinds_)
      sum +=
          kind.number *
          right(kind.record, excess, curl, plants_.curl_deviation()).unaryExpr([&](double value) {
            return log_sum(std::log1p(-kind.wrong()) + value,
                           std::log(kind.wrong()) + kind.expected);
          });
    return sum;
  }

  /// (record) probability that it is wrong.
  Eigen::VectorXd wrong(const Eigen::MatrixXd& places) const {
    Eigen::VectorXd of_kinds(kinds_.size());
    for (std::size_t i = 0; i < kinds_.size(); ++i) {
      const double is_wrong = std::log(kinds_[i].wrong()) + kinds_[i].expected;
      const double is_right = std::log1p(-kinds_[i].wrong());
      of_kinds(i) = right_at(places, kinds_[i].record)
                        .unaryExpr([&](double value) {
                          return std::exp(is_wrong - log_sum(is_right + value, is_wrong));
                        })
                        .mean();
    }
    return of_kinds(kind_of_);
  }

private:
  Eigen::VectorXd right_at(const Eigen::MatrixXd& places, const LineRecord& record) const {
    return right(record, plants_.excess(places), plants_.curl(places), plants_.curl_deviation());
  }

  const Plants& plants_;
  std::vector<EqualRecords> kinds_;
  std::vector<std::size_t> kind_of_;  ///< (record)
};

Eigen::VectorXd sorted(Eigen::VectorXd values) {
  std::ranges::sort(values);
  return values;
}

/// Curls of castings of all plants. @param plants  (draw) what each has on average
Eigen::VectorXd draw_curls(const Eigen::VectorXd& plants, double deviation, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::VectorXd curls(plants.size() * castings_of_draw);
  for (Eigen::Index i = 0; i < curls.size(); ++i)
    curls(i) = plants(i % plants.size()) + deviation * normal(random);
  return curls;
}

/// Share of the variance of `figure` that goes with each input, to first order.
/// @param noise  variance of what no input moves
Eigen::VectorXd told_by(const Eigen::MatrixXd& inputs, const Eigen::VectorXd& figure,
                        double noise) {
  const Eigen::VectorXd off = figure.array() - figure.mean();
  const Eigen::MatrixXd moved = inputs.rowwise() - inputs.colwise().mean();
  const Eigen::ArrayXd shared = (moved.transpose() * off).array().square();
  const Eigen::ArrayXd own = moved.colwise().squaredNorm().transpose().array().max(1e-300);
  const auto count = static_cast<double>(figure.size());
  return shared / own / (off.squaredNorm() + count * noise + 1e-300);
}

}  // namespace

LinePosterior next_casting(const LineModel& model, const std::vector<LineRecord>& records,
                           std::uint64_t seed) {
  const Plants plants(model, seed);
  const Evidence evidence(plants, records);
  const PosteriorDraws drawn =
      draw_posterior([&](const Eigen::MatrixXd& places) { return evidence.log_likelihood(places); },
                     plants.inputs(), plants_drawn, seed + 1);

  LinePosterior next;
  next.effective_draws = drawn.effective;
  next.wrong = evidence.wrong(drawn.places);
  const Eigen::MatrixXd sound =
      plants.excess(drawn.places).unaryExpr([](double excess) { return normal_below(-excess); });
  const Eigen::VectorXd shares = sorted(1.0 - sound.rowwise().prod().array());
  next.danger = shares.mean();
  next.danger_low = quantile(shares, 0.05);
  next.danger_high = quantile(shares, 0.95);
  next.castings = plants.cast(drawn.places, seed + 3);
  if (!model.curl) return next;

  const Eigen::VectorXd of_plants = plants.curl(drawn.places);
  const double deviation = plants.curl_deviation();
  const Eigen::VectorXd curls = sorted(draw_curls(of_plants, deviation, seed + 2));
  next.curl_low = quantile(curls, 0.05);
  next.curl_median = quantile(curls, 0.5);
  next.curl_high = quantile(curls, 0.95);
  next.told = told_by(drawn.places.leftCols(model.inputs), of_plants, deviation * deviation);
  return next;
}

}  // namespace dccast::statistics
