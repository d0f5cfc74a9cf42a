#include "server/studies/curl_prior.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/statistics/line_memory.hpp"
#include "proto/values/interpolation.hpp"
#include "server/judging/judged_study.hpp"
#include "server/studies/run_curves.hpp"

namespace dccast::studies {

namespace {

/// Standard deviation of the error of the model besides data and mesh, as a share of the curl,
/// where it is not known from castings on the line (docs/forecasts.md).
constexpr double model_error = 0.05;
/// Fewest pairs from which the error of the mesh is estimated: fewer have no scatter.
constexpr int fewest_pairs = 2;

// What may be true of a line, each as likely as the others before it has castings.
constexpr std::array model_errors{0.025, 0.05, 0.1};
constexpr std::array scatters{0.03, 0.1, 0.2, 0.4, 0.7};
/// A casting loses half its weight in some twenty later ones.
constexpr double kept = 0.97;
/// Castings on a line that are used, the newest.
constexpr std::size_t most_castings = 30;

/// Curves of runs that count, by the data of the run: keys and values.
using CurvesByData = std::map<std::string, const v1::CurlCurve*>;

CurvesByData curves_of(const v1::StudyResult& study, const std::string& monitor) {
  std::string keys;
  for (const v1::SweepPlan::Axis& axis : study.study().sweep().axes()) keys += axis.key() + '\n';

  CurvesByData curves;
  for (const v1::StudyRun& run : study.runs()) {
    const v1::CurlCurve* const curve = find_curve(run.curves(), monitor);
    if (curve && curve->time_s_size() > 1 && judging::is_valid(run))
      curves[keys + fmt::format("{}", fmt::join(run.values(), "\n"))] = curve;
  }
  return curves;
}

/// Curves of a gauge on one recipe: of all members, and of those run at a finer quality too.
struct Recipe {
  CurvesByData members, finer;
};

Recipe recipe_of(const v1::StudyResult& ensemble, const v1::StudyResult& pairs,
                 const std::string& monitor) {
  Recipe recipe{curves_of(ensemble, monitor), curves_of(pairs, monitor)};
  std::erase_if(recipe.finer, [&](const auto& run) { return !recipe.members.contains(run.first); });
  return recipe;
}

/// Leaves the data that the other recipe has too.
void keep_shared(CurvesByData& curves, const CurvesByData& others) {
  std::erase_if(curves, [&](const auto& run) { return !others.contains(run.first); });
}

int count_shared(const CurvesByData& curves, const CurvesByData& others) {
  return static_cast<int>(
      std::ranges::count_if(curves, [&](const auto& run) { return others.contains(run.first); }));
}

/// The end of the shortest run [s].
double end_of(const Recipe& recipe) {
  double end = INFINITY;
  for (const CurvesByData* curves : {&recipe.members, &recipe.finer})
    for (const auto& [data, curve] : *curves) end = std::min(end, *curve->time_s().rbegin());
  return end;
}

/// Instants from the start of the block to the end of the shortest run: every second, of a long
/// casting fewer.
std::vector<double> instants_of(const Recipe& recipe) {
  constexpr double most = 600.0;
  const double end = end_of(recipe);
  const auto count = static_cast<Eigen::Index>(std::clamp(std::floor(end), 2.0, most));
  const Eigen::VectorXd instants = Eigen::VectorXd::LinSpaced(count + 1, 0.0, end);
  return {instants.begin(), instants.end()};
}

/// Curls at instants [m]; zero while there is none.
Eigen::VectorXd curl_at(const std::vector<double>& instants, const v1::CurlCurve& curve) {
  std::vector<double> curl(curve.curl_m().begin(), curve.curl_m().end());
  std::ranges::replace_if(
      curl, [](double each) { return !std::isfinite(each); }, 0.0);
  const auto at =
      values::at_instants(instants, {curve.time_s().begin(), curve.time_s().end()}, curl);
  return Eigen::VectorXd::Map(at.data(), static_cast<Eigen::Index>(at.size()));
}

/// Instants of one recipe after another, as the joint prior has them.
struct Block {
  const Recipe* recipe;
  std::vector<double> instants;
};

/// (run, instant of all blocks) curls [m] of the data that `of` names.
Eigen::MatrixXd curls_of(const std::vector<Block>& blocks, CurvesByData Recipe::*quality,
                         const CurvesByData& of) {
  Eigen::Index instants = 0;
  for (const Block& block : blocks) instants += static_cast<Eigen::Index>(block.instants.size());

  Eigen::MatrixXd curls(of.size(), instants);
  Eigen::Index row = 0;
  for (const auto& [data, curve] : of) {
    Eigen::Index begin = 0;
    for (const Block& block : blocks) {
      const auto count = static_cast<Eigen::Index>(block.instants.size());
      curls.row(row).segment(begin, count) =
          curl_at(block.instants, *(block.recipe->*quality).at(data));
      begin += count;
    }
    ++row;
  }
  return curls;
}

/// The error of mesh and time steps of a study's runs; zero where it was not measured.
v1::RelativeError mesh_error_of(const v1::StudyResult& study) {
  const auto run = std::ranges::find_if(study.runs(), &v1::StudyRun::has_mesh_error);
  return run == study.runs().end() ? v1::RelativeError() : run->mesh_error();
}

/// Runs of the same data on all recipes, and the error of the mesh that pairs, or without pairs the
/// members themselves, leave: the band of their quality. By its middle they are too low, and half
/// its width is the error of nine in ten.
class JointEnsemble {
public:
  JointEnsemble(const std::vector<Block>& blocks, const ForecastBasis& basis) {
    const Recipe& next = *blocks.front().recipe;
    const bool has_pairs = std::ssize(next.finer) >= fewest_pairs;

    for (const Block& block : blocks)
      instants_.insert(instants_.end(), block.instants.begin(), block.instants.end());
    members_ = curls_of(blocks, &Recipe::members, next.members);
    if (has_pairs)
      misfits_ = curls_of(blocks, &Recipe::finer, next.finer) -
                 curls_of(blocks, &Recipe::members, next.finer);
    mesh_error_ = mesh_error_of(has_pairs ? basis.pairs : basis.ensemble);
  }

  /// At the first instants alone. @param error  of the model besides data and mesh
  statistics::TrajectoryEnsemble ensemble(double error, Eigen::Index instants) const {
    const double of_mesh = 0.5 * (mesh_error_.lower() + mesh_error_.upper()) / nine_of_ten;
    const auto pairs = misfits_.rows() > 0 ? instants : 0;
    return {.time = Eigen::VectorXd::Map(instants_.data(), instants),
            .nominal = members_.leftCols(instants).colwise().mean(),
            .members = members_.leftCols(instants),
            .misfits = misfits_.leftCols(pairs),
            .model_error = std::hypot(error, of_mesh)};
  }

  /// @param error  of the model besides data and mesh
  statistics::TrajectoryPrior prior(double error) const {
    auto prior = statistics::prior_of(ensemble(error, std::ssize(instants_)));
    const double too_low = 0.5 * (mesh_error_.upper() - mesh_error_.lower());
    prior.deviation += too_low * (prior.nominal + prior.deviation);
    return prior;
  }

private:
  std::vector<double> instants_;
  Eigen::MatrixXd members_;  ///< (member, instant) [m]
  Eigen::MatrixXd misfits_;  ///< (pair, instant) finer minus member [m]
  v1::RelativeError mesh_error_;
};

/// A casting on the line that counts, its recipe and what was measured.
struct CountingCasting {
  Recipe recipe;
  v1::ObservedCurl curl;  ///< as long as the runs of the recipe
  double zero_m;
};

/// What was measured until a time.
v1::ObservedCurl observed_until(double end_s, v1::ObservedCurl curl) {
  const auto count =
      static_cast<int>(std::ranges::upper_bound(curl.time_s(), end_s) - curl.time_s().begin());
  curl.mutable_time_s()->Truncate(count);
  curl.mutable_curl_m()->Truncate(count);
  curl.mutable_deviation_m()->Truncate(count);
  return curl;
}

/// The castings on the line that count at a gauge, the oldest first. The recipe of the next casting
/// keeps the runs of data that all of them have.
std::vector<CountingCasting> counting_castings(const ForecastBasis& basis,
                                               const std::string& monitor, Recipe& next,
                                               std::vector<std::string>& notes) {
  std::vector<CountingCasting> counting;
  for (auto each = basis.earlier.rbegin(); each != basis.earlier.rend(); ++each) {
    if (counting.size() == most_castings) break;
    const v1::LineCasting& casting = each->casting;
    const auto curl = std::ranges::find(casting.curls(), monitor, &v1::ObservedCurl::monitor);
    if (curl == casting.curls().end() || curl->time_s().empty()) continue;

    const auto leave_out = [&](const char* reason) {
      notes.push_back(fmt::format("the casting of job {} on the line does not count: {}",
                                  casting.job(), reason));
    };
    if (!each->ensemble) {
      leave_out("its study is not there any more");
      continue;
    }
    Recipe recipe = recipe_of(*each->ensemble, *each->pairs, monitor);
    if (count_shared(next.members, recipe.members) < fewest_members) {
      leave_out("its ensemble has other data");
      continue;
    }

    keep_shared(next.members, recipe.members);
    keep_shared(next.finer, recipe.finer);
    keep_shared(next.finer, next.members);
    const auto& gauges = casting.following().gauges();
    const auto gauge = std::ranges::find(gauges, monitor, &v1::Gauge::monitor);
    const double zero_m = gauge == gauges.end() ? 0.0 : gauge->zero_m();
    auto observed = observed_until(end_of(recipe), *curl);
    counting.push_back({std::move(recipe), std::move(observed), zero_m});
  }
  std::ranges::reverse(counting);
  return counting;
}

/// What castings measured at instants of the joint prior, which begins with the next casting.
std::vector<statistics::MeasuredCasting> measured(const std::vector<CountingCasting>& castings,
                                                  Eigen::Index instants_of_next) {
  std::vector<statistics::MeasuredCasting> all;
  Eigen::Index instant = instants_of_next;
  for (const auto& [recipe, curl, zero_m] : castings) {
    const Eigen::Index count = curl.time_s_size();
    statistics::MeasuredCasting& casting = all.emplace_back();
    casting.zero = zero_m;
    casting.values = Eigen::VectorXd::Map(curl.curl_m().data(), count);
    casting.noise = Eigen::VectorXd::Map(curl.deviation_m().data(), count);
    for (Eigen::Index i = 0; i < count; ++i) casting.instants.push_back(instant++);
  }
  return all;
}

/// The prior that castings on the line leave. How much differs from casting to casting, and the
/// error of the model, are weighed by how likely they make what was measured.
statistics::TrajectoryPrior informed_prior(const JointEnsemble& joint, Eigen::Index instants,
                                           const std::vector<CountingCasting>& castings,
                                           v1::LineMemory& line) {
  const auto of_castings = measured(castings, instants);
  std::vector<statistics::Informed> informed;
  std::vector<double> likelihood;
  for (const double error : model_errors) {
    const auto prior = joint.prior(error);
    for (const double scatter : scatters) {
      informed.push_back(
          statistics::inform(prior, instants, of_castings, {.scatter = scatter, .kept = kept}));
      likelihood.push_back(informed.back().log_likelihood);
    }
  }

  const Eigen::VectorXd weights =
      statistics::weights_of(Eigen::VectorXd::Map(likelihood.data(), std::ssize(likelihood)));
  Eigen::Index assumption = 0;
  for (const double error : model_errors)
    for (const double scatter : scatters) {
      const double weight = weights(assumption++);
      line.set_model_error(line.model_error() + weight * error);
      line.set_scatter(line.scatter() + weight * scatter);
    }
  return statistics::mixture_of(informed, weights);
}

/// The prior of the run of the plan alone.
CurlPrior prior_of_plan(const ForecastBasis& basis, const std::string& monitor) {
  const v1::CurlCurve* const curve = find_curve(basis.plan_run, monitor);
  if (!curve || curve->time_s_size() < 2)
    throw CannotForecast(fmt::format("the run of the plan, job {}, has no curl of \"{}\"",
                                     basis.following.plan_job(), monitor));

  const std::vector<double> instants = instants_of({.members = {{"plan", curve}}, .finer = {}});
  return {.trajectory = statistics::random_walk_about(
              Eigen::VectorXd::Map(instants.data(), std::ssize(instants)),
              curl_at(instants, *curve), basis.error_of_plan)};
}

}  // namespace

double error_of_plan(const v1::Section& section) {
  // With these the bands hold nine of ten castings whose data are drawn from the ranges of a
  // shipped case (tests/verification/forecast_castings.py --unprepared).
  constexpr double of_quarter_slab = 0.25, of_section = 0.5;
  return section.kind() == v1::Section::QUARTER_SLAB ? of_quarter_slab : of_section;
}

CurlPrior prior_of_curl(const ForecastBasis& basis, const std::string& monitor) {
  if (basis.following.ensemble().empty()) return prior_of_plan(basis, monitor);

  Recipe next = recipe_of(basis.ensemble, basis.pairs, monitor);
  CurlPrior known{.members = static_cast<int>(next.members.size())};
  if (known.members < fewest_members)
    throw CannotForecast(fmt::format("{} runs of study {} count so far, {} are needed",
                                     known.members, basis.following.ensemble(), fewest_members));

  if (!basis.following.line().empty()) known.line.emplace();
  const auto castings = counting_castings(basis, monitor, next, known.notes);
  known.members = static_cast<int>(next.members.size());
  std::vector<Block> blocks{{&next, instants_of(next)}};
  const auto instants = std::ssize(blocks.front().instants);
  for (const auto& [recipe, curl, zero_m] : castings)
    blocks.push_back({&recipe, {curl.time_s().begin(), curl.time_s().end()}});

  const JointEnsemble joint(blocks, basis);
  known.ensemble = joint.ensemble(model_error, instants);
  if (castings.empty()) {
    known.trajectory = joint.prior(model_error);
  } else {
    known.line->set_castings(static_cast<int>(castings.size()));
    known.trajectory = informed_prior(joint, instants, castings, *known.line);
  }
  return known;
}

}  // namespace dccast::studies
