#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/statistics/principal_components.hpp"
#include "core/statistics/sampling.hpp"
#include "core/statistics/sobol_indices.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

/// Curls that are accepted [m].
struct CurlBand {
  double least = 0.0, greatest = 0.0;
};

/// The curl of one monitor as a function of inputs that are uniform in (0, 1).
struct SampledCurls {
  statistics::SampledFunction curls;  ///< (place, input) -> (place, instant) [m]
  std::vector<double> time_s, cast_length_m;
  std::vector<double> error_m;  ///< by instant: root mean square of what `curls` is off
};

/// What the inputs leave open: the 5, 50 and 95 % curl at every instant, with the error of the
/// function as normal noise, and the shares of the inputs in the variance of the curl at some
/// instants; the last share is that of the error. The same whenever the function is.
v1::Spread spread_of(const SampledCurls& sampled, int inputs, const std::optional<CurlBand>& band);

/// The range of one input, in the unit of the schema.
struct InputRange {
  double low = 0.0;
  double high = 0.0;
};

/// A run at a place of the domain.
struct SurfaceRun {
  std::vector<double> place;  ///< by input, in the unit of the schema
  RunHistory history;
};

/// The curl against time of all monitors as a function of some inputs. The curves of the runs are
/// taken apart into their principal components, whose amounts are Gaussian processes over the
/// inputs.
class CurlSurface {
public:
  /// @param runs      fewest_runs() or more
  /// @param monitors  those of the case
  CurlSurface(std::vector<InputRange> domain, std::vector<SurfaceRun> runs,
              std::vector<std::string> monitors);

  /// Runs that a surface over `inputs` inputs needs.
  static std::size_t fewest_runs(std::size_t inputs) {
    return std::max<std::size_t>(5, inputs + 3);
  }

  /// Curves with standard errors. @param place  inside the domain
  std::vector<v1::CurlCurve> predict(const std::vector<double>& place) const;
  /// Root mean square of what runs left out one by one are off at the end, of the worst monitor
  /// [m].
  double cross_validated_error_m() const { return error_m_; }
  /// What the inputs leave open of a monitor's curl when they vary over the whole domain.
  /// @param band  of curls that are accepted [m]; empty: none
  v1::Spread spread(const std::string& monitor, const std::optional<CurlBand>& band) const;
  /// Where the curls at the end are least certain. @return by input, 0 to 1 over the domain
  const std::vector<double>& next_place() const { return next_place_; }
  int runs() const { return runs_; }
  /// Of memory, most of it.
  std::size_t bytes() const { return curls_.bytes() + lengths_.bytes(); }

private:
  Eigen::RowVectorXd scaled(const std::vector<double>& place) const;
  Eigen::MatrixXd scaled_places(const std::vector<SurfaceRun>& runs) const;
  Eigen::MatrixXd curl_figures(const std::vector<SurfaceRun>& runs);

  std::vector<InputRange> domain_;
  int runs_;
  std::vector<std::string> monitors_;
  std::vector<double> time_s_;
  std::vector<std::vector<Eigen::Index>> figure_;  ///< (monitor, instant); -1: not known
  Eigen::MatrixXd places_;
  statistics::PrincipalComponents curls_;
  statistics::PrincipalComponents lengths_;
  double error_m_ = 0.0;
  std::vector<double> next_place_;
};

}  // namespace dccast::studies
