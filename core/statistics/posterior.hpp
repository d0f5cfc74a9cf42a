#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

namespace dccast::statistics {

/// Logarithm of a likelihood, up to a constant.
/// @param  (place, input)  @return (place); infinite or NaN where a place is impossible
using LogLikelihood = std::function<Eigen::VectorXd(const Eigen::MatrixXd&)>;

/// Draws from the posterior: the prior after the observations.
struct PosteriorDraws {
  Eigen::MatrixXd places;     ///< (draw, input), in the units of the prior
  double log_evidence = 0.0;  ///< logarithm of the mean likelihood over the prior
  /// Number of draws that are nearly independent of each other [1]: those that differed when the
  /// last walk began, and of the others the share that the walk has renewed.
  double effective = 0.0;
};

/// Draws from the posterior of inputs whose prior is independent and standard normal. The
/// likelihood is raised to powers that grow from 0 to 1, each chosen so that half of the draws
/// count; the draws are resampled and moved by random-walk Metropolis steps (Ching and Chen 2007)
/// until they are nearly uncorrelated with their beginning. Separate modes are found if the prior
/// draws reach them. The result is the same on every machine that evaluates the likelihood alike.
/// @param inputs  number of inputs  @param draws  number of draws, two or more
PosteriorDraws draw_posterior(const LogLikelihood& likelihood, int inputs, int draws,
                              std::uint64_t seed);

}  // namespace dccast::statistics
