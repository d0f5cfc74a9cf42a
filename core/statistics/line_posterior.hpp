#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace dccast::statistics {

/// A figure of a casting as a function of the data.
struct LineSurface {
  /// @param  (place, input), 0 to 1  @return (place) the figure; of a danger its excess
  std::function<Eigen::VectorXd(const Eigen::MatrixXd&)> mean;
  double error = 0.0;  ///< standard deviation of the error of `mean`, in its unit
};

/// How castings of one recipe depend on data that are uniform in (0, 1) and independent. What is
/// not known of a plant, the data and the errors of the surfaces, has a part that stays from
/// casting to casting and a part that each casting draws anew. Equal castings are therefore no
/// independent proofs.
struct LineModel {
  int inputs = 0;                    ///< number of data
  std::vector<LineSurface> dangers;  ///< a casting is in danger where one of them is above zero
  std::optional<LineSurface> curl;   ///< absent: not known
  double scatter = 0.2;              ///< [1] share of the variance that each casting draws anew
};

/// What is known of one casting, or of several that went alike.
struct LineRecord {
  std::vector<std::optional<bool>> dangers;  ///< (danger) whether it came; empty: not known
  double count = 1.0;                        ///< castings with these dangers
  std::optional<double> curl{};              ///< measured in one of them
  double curl_noise = 1.0;                   ///< standard deviation of the measurement, above 0
  /// Whether two records say the same, so that they cost one evaluation.
  bool operator==(const LineRecord&) const = default;
};

/// The next casting, over all plants that are possible after the records.
struct LinePosterior {
  double danger = 0.0;       ///< [1] mean over the plants
  double danger_low = 0.0;   ///< [1] 5 % quantile of the plants' shares
  double danger_high = 0.0;  ///< [1] 95 % quantile
  double curl_low = 0.0;     ///< 5 % quantile, in the unit of the curl's surface
  double curl_median = 0.0;  ///< 50 %
  double curl_high = 0.0;    ///< 95 %
  /// (input) share of the variance of the curl that would go if the plant's part of a datum were
  /// known, where the curl is linear in it [1]
  Eigen::VectorXd told;
  Eigen::MatrixXd castings;      ///< (draw, input) data of a casting of each plant, 0 to 1
  Eigen::VectorXd wrong;         ///< (record) probability that it says nothing of this plant [1]
  double effective_draws = 0.0;  ///< [1] on which the figures rest
};

/// Draws plants by draw_posterior(). A record of n castings is wrong with a probability of 0.01 /
/// n, with a danger of 0.001 / n; it then says nothing, so that one that no plant can explain does
/// not move the others. To save evaluations the part that a casting draws anew has the same
/// variance everywhere.
/// @param records  the dangers of each as many as those of the model
LinePosterior next_casting(const LineModel& model, const std::vector<LineRecord>& records,
                           std::uint64_t seed);

}  // namespace dccast::statistics
