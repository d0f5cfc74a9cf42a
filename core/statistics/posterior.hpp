#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

namespace dccast::statistics {

/// Logarithm of a likelihood, up to a constant. @param  (place, input)  @return (place)
using LogLikelihood = std::function<Eigen::VectorXd(const Eigen::MatrixXd&)>;

/// What observations leave of inputs.
struct PosteriorDraws {
  Eigen::MatrixXd places;     ///< (draw, input)
  double log_evidence = 0.0;  ///< logarithm of the mean likelihood before the observations
  int stages = 0;
};

/// Draws from the posterior of inputs that are independent and standard normal before. The
/// likelihood is raised to powers that grow from 0 to 1, each chosen so that half of the draws
/// count; the draws are resampled and moved by random-walk Metropolis steps (Ching and Chen 2007),
/// until their correlation with where they began is small. Finds separate modes, if the prior draws
/// touch them. The same on every machine that evaluates the likelihood alike.
PosteriorDraws draw_posterior(const LogLikelihood& likelihood, int inputs, int draws,
                              std::uint64_t seed);

/// The place in (0, 1) of a standard normal number: uniform before.
double uniform_place(double normal);

}  // namespace dccast::statistics
