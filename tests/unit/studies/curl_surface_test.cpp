#include "server/studies/curl_surface.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>

#include "core/statistics/sampling.hpp"

namespace dccast::studies {
namespace {

// Casting speed [m/s] and a factor on the water.
const std::vector<InputRange> domain{{0.5e-3, 1.5e-3}, {0.6, 1.2}};

double curl(const std::vector<double>& place, double t) {
  const double speed = place[0] / 1e-3, water = place[1];
  return 1e-3 * (1.0 - std::exp(-0.05 * t * speed)) * (4.0 + 2.0 * water + std::sin(2.0 * speed));
}

/// Steps of 1 s to 100 s; the corner is reported from 10 s on.
SurfaceRun run_at(const std::vector<double>& place) {
  SurfaceRun run{place, {}};
  v1::CurlCurve& curve = run.history.curves.emplace_back();
  curve.set_monitor("corner");
  for (int t = 1; t <= 100; ++t) {
    curve.add_time_s(t);
    curve.add_cast_length_m(place[0] * t);
    curve.add_curl_m(t < 10 ? std::numeric_limits<double>::quiet_NaN() : curl(place, t));
  }
  return run;
}

std::vector<double> place_in_domain(const Eigen::RowVectorXd& unit) {
  std::vector<double> place;
  for (std::size_t j = 0; j < domain.size(); ++j)
    place.push_back(domain[j].low +
                    unit[static_cast<Eigen::Index>(j)] * (domain[j].high - domain[j].low));
  return place;
}

CurlSurface surface_of(int runs) {
  std::vector<SurfaceRun> all;
  const Eigen::MatrixXd places = statistics::hypercube(runs, 2, 1);
  for (const auto& unit : places.rowwise()) all.push_back(run_at(place_in_domain(unit)));
  return CurlSurface(domain, all, {"corner", "elsewhere"});
}

TEST(CurlSurface, PredictsCurvesItHasNotSeenWithinWhatItSays) {
  const CurlSurface surface = surface_of(30);
  EXPECT_EQ(surface.runs(), 30);
  EXPECT_LT(surface.cross_validated_error_m(), 0.05e-3);

  int inside = 0, asked = 0;
  double square = 0.0;
  const Eigen::MatrixXd unseen = statistics::hypercube(50, 2, 77);
  for (const auto& unit : unseen.rowwise()) {
    const auto place = place_in_domain(unit);
    const auto curves = surface.predict(place);
    ASSERT_EQ(curves.size(), 2u);
    const v1::CurlCurve& corner = curves.front();
    const int last = corner.time_s_size() - 1;
    EXPECT_EQ(corner.time_s(last), 100.0);
    EXPECT_TRUE(std::isnan(corner.curl_m(0)));
    EXPECT_NEAR(corner.cast_length_m(last), 100.0 * place[0], 1e-4 * place[0] * 100.0 + 1e-5);
    EXPECT_TRUE(std::isnan(curves[1].curl_m(last)));
    for (int i = 20; i <= last; i += 10, ++asked) {
      const double off = corner.curl_m(i) - curl(place, corner.time_s(i));
      inside += std::abs(off) < 3.0 * corner.uncertainty_m(i) + 1e-7 ? 1 : 0;
    }
    const double off = corner.curl_m(last) - curl(place, 100.0);
    square += off * off / 50.0;
  }
  // The error that it reports is the true one, within a factor of three.
  EXPECT_LT(std::sqrt(square), 3.0 * surface.cross_validated_error_m());
  EXPECT_GT(inside, 0.9 * asked);
}

TEST(CurlSurface, MoreRunsMakeItBetter) {
  EXPECT_LT(surface_of(40).cross_validated_error_m(),
            0.5 * surface_of(8).cross_validated_error_m());
}

TEST(CurlSurface, WantsTheRunThatItKnowsLeastOf) {
  std::vector<SurfaceRun> runs;  // nothing at high speed
  const Eigen::MatrixXd places = statistics::hypercube(20, 2, 1);
  for (const auto& unit : places.rowwise())
    runs.push_back(run_at(place_in_domain(Eigen::RowVector2d(0.5 * unit[0], unit[1]))));
  const CurlSurface surface(domain, runs, {"corner"});
  EXPECT_GT(surface.next_place()[0], 0.85);
}

TEST(CurlSurface, AnswersAtOnce) {
  const CurlSurface surface = surface_of(200);
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 20; ++i) surface.predict({1e-3, 0.6 + 0.01 * i});
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(took.count() / 20, 0.05);  // 1 ms on an idle machine
}

}  // namespace
}  // namespace dccast::studies
