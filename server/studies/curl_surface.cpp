#include "server/studies/curl_surface.hpp"

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "core/statistics/principal_components.hpp"
#include "core/statistics/sampling.hpp"
#include "proto/values/interpolation.hpp"

namespace dccast::studies {

namespace {

constexpr std::size_t most_instants = 150;
constexpr std::size_t most_runs = 1000;            // beyond them the surface gains nothing but time
constexpr std::size_t most_for_cast_length = 200;  // it follows the recipe alone, smoothly
constexpr int candidates = 200;                    // for the next run
constexpr std::size_t most_inputs_with_corners = 6;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

std::vector<double> values_of(const google::protobuf::RepeatedField<double>& field) {
  return {field.begin(), field.end()};
}

/// Instants that all runs have, those of the first run's steps; thinned, the last one kept.
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
  std::vector<double> instants;
  const std::size_t stride = (inside.size() + most_instants - 1) / most_instants;
  for (std::size_t i = (inside.size() - 1) % stride; i < inside.size(); i += stride)
    instants.push_back(inside[i]);
  return instants;
}

Eigen::MatrixXd places_of(const std::vector<std::vector<double>>& places) {
  Eigen::MatrixXd matrix(places.size(), places.front().size());
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t j = 0; j < places[i].size(); ++j)
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = places[i][j];
  return matrix;
}

/// At most as many as the cast length needs, spread over all.
Eigen::MatrixXd some_rows(const Eigen::MatrixXd& all) {
  const Eigen::Index count = std::min<Eigen::Index>(all.rows(), most_for_cast_length);
  Eigen::MatrixXd some(count, all.cols());
  for (Eigen::Index i = 0; i < count; ++i) some.row(i) = all.row(i * all.rows() / count);
  return some;
}

/// A spread over the domain, and its corners, where surfaces are least certain.
Eigen::MatrixXd candidate_places(std::size_t inputs) {
  auto places = statistics::latin_hypercube(candidates, static_cast<int>(inputs), 1);
  if (inputs <= most_inputs_with_corners)
    for (const auto& corner : statistics::grid(std::vector<int>(inputs, 2)))
      places.emplace_back(corner.begin(), corner.end());
  return places_of(places);
}

}  // namespace

class CurlSurface::Parts {
public:
  Parts(std::vector<InputRange> domain, std::vector<SurfaceRun> runs,
        const std::vector<std::string>& monitors)
      : domain_(std::move(domain)),
        runs_(static_cast<int>(runs.size())),
        monitors_(monitors),
        time_s_(common_instants(runs)),
        places_(scaled_places(runs)),
        curls_(places_, curl_figures(runs)),
        lengths_(some_rows(places_), some_rows(length_figures(runs))) {
    judge();
  }

  std::vector<v1::CurlCurve> predict(const std::vector<double>& place) const {
    const Eigen::RowVectorXd at = scaled(place);
    const auto curls = curls_.estimate(at);
    const auto lengths = lengths_.estimate(at);
    std::vector<v1::CurlCurve> curves(monitors_.size());
    for (std::size_t m = 0; m < monitors_.size(); ++m) {
      curves[m].set_monitor(monitors_[m]);
      for (std::size_t i = 0; i < time_s_.size(); ++i) {
        const Eigen::Index figure = figure_[m][i];
        curves[m].add_time_s(time_s_[i]);
        curves[m].add_cast_length_m(lengths.mean(static_cast<Eigen::Index>(i)));
        curves[m].add_curl_m(figure < 0 ? unknown : curls.mean(figure));
        curves[m].add_uncertainty_m(figure < 0 ? unknown : std::sqrt(curls.variance(figure)));
      }
    }
    return curves;
  }

  int runs() const { return runs_; }
  std::size_t bytes() const { return curls_.bytes() + lengths_.bytes(); }
  double error_m() const { return error_m_; }
  const std::vector<double>& next_place() const { return next_place_; }

private:
  Eigen::RowVectorXd scaled(const std::vector<double>& place) const {
    Eigen::RowVectorXd row(place.size());
    for (std::size_t j = 0; j < place.size(); ++j) {
      const double width = domain_[j].high - domain_[j].low;
      row(static_cast<Eigen::Index>(j)) = width > 0.0 ? (place[j] - domain_[j].low) / width : 0.0;
    }
    return row;
  }

  Eigen::MatrixXd scaled_places(const std::vector<SurfaceRun>& runs) const {
    Eigen::MatrixXd places(runs.size(), domain_.size());
    for (std::size_t i = 0; i < runs.size(); ++i)
      places.row(static_cast<Eigen::Index>(i)) = scaled(runs[i].place);
    return places;
  }

  /// (run, instant) of one monitor; NaN where it is not reported.
  Eigen::MatrixXd curls_of(const std::vector<SurfaceRun>& runs, const std::string& monitor) const {
    Eigen::MatrixXd curls = Eigen::MatrixXd::Constant(runs.size(), time_s_.size(), unknown);
    for (std::size_t i = 0; i < runs.size(); ++i)
      if (const v1::CurlCurve* curve = runs[i].history.curve(monitor)) {
        const auto values =
            values::at_instants(time_s_, values_of(curve->time_s()), values_of(curve->curl_m()));
        curls.row(static_cast<Eigen::Index>(i)) =
            Eigen::Map<const Eigen::RowVectorXd>(values.data(), curls.cols());
      }
    return curls;
  }

  /// (run, figure) curls of all monitors at the instants at which every run reports them; fills
  /// figure_.
  Eigen::MatrixXd curl_figures(const std::vector<SurfaceRun>& runs) {
    std::vector<Eigen::VectorXd> columns;
    for (const std::string& monitor : monitors_) {
      const Eigen::MatrixXd curls = curls_of(runs, monitor);
      auto& figure = figure_.emplace_back(time_s_.size(), -1);
      for (Eigen::Index i = 0; i < curls.cols(); ++i) {
        if (!curls.col(i).allFinite()) continue;
        figure[static_cast<std::size_t>(i)] = static_cast<Eigen::Index>(columns.size());
        columns.push_back(curls.col(i));
      }
    }
    Eigen::MatrixXd figures(runs.size(), columns.size());
    for (std::size_t k = 0; k < columns.size(); ++k)
      figures.col(static_cast<Eigen::Index>(k)) = columns[k];
    return figures;
  }

  /// (run, instant) cast lengths.
  Eigen::MatrixXd length_figures(const std::vector<SurfaceRun>& runs) const {
    Eigen::MatrixXd lengths(runs.size(), time_s_.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const v1::CurlCurve& curve = runs[i].history.curves.front();
      const auto values =
          values::at_instants(time_s_, values_of(curve.time_s()), values_of(curve.cast_length_m()));
      lengths.row(static_cast<Eigen::Index>(i)) =
          Eigen::Map<const Eigen::RowVectorXd>(values.data(), lengths.cols());
    }
    return lengths;
  }

  /// Sets error_m_ and next_place_.
  void judge() {
    std::vector<Eigen::Index> ends;
    for (const auto& figure : figure_)
      if (figure.back() >= 0) ends.push_back(figure.back());
    for (const Eigen::Index end : ends)
      error_m_ = std::max(error_m_, curls_.left_out_errors(end).norm() / std::sqrt(runs_));
    const Eigen::MatrixXd places = candidate_places(domain_.size());
    Eigen::Index widest = 0;
    curls_.variance_of(places, ends).maxCoeff(&widest);
    for (Eigen::Index j = 0; j < places.cols(); ++j) next_place_.push_back(places(widest, j));
  }

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

CurlSurface::CurlSurface(std::vector<InputRange> domain, const std::vector<SurfaceRun>& runs,
                         const std::vector<std::string>& monitors) {
  std::vector<SurfaceRun> some;
  const std::size_t count = std::min(runs.size(), most_runs);
  for (std::size_t i = 0; i < count; ++i) some.push_back(runs[i * runs.size() / count]);
  parts_ = std::make_unique<const Parts>(std::move(domain), std::move(some), monitors);
}

CurlSurface::~CurlSurface() = default;

std::vector<v1::CurlCurve> CurlSurface::predict(const std::vector<double>& place) const {
  return parts_->predict(place);
}

double CurlSurface::cross_validated_error_m() const {
  return parts_->error_m();
}

const std::vector<double>& CurlSurface::next_place() const {
  return parts_->next_place();
}

int CurlSurface::runs() const {
  return parts_->runs();
}

std::size_t CurlSurface::bytes() const {
  return parts_->bytes();
}

}  // namespace dccast::studies
