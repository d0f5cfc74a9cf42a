#include "server/studies/advice.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "proto/values/interpolation.hpp"
#include "server/studies/curl_prior.hpp"

namespace dccast::studies {

namespace {

constexpr double least_gain_m = 1e-3;

/// Least number of castings from which an effect is estimated: fewer have no scatter.
constexpr int fewest_castings = 5;
/// Standard deviation of an effect by mesh and steps of a draft: a share of it, and what remains of
/// a small one (docs/forecasts.md).
constexpr double mesh_share = 0.2;
constexpr double least_error_m = 0.3e-3;

/// The runs of a lever in one direction, by the time from which on it is moved.
using Moves = std::vector<const v1::LeverEffect*>;

/// A casting of some data: its plan, and each lever.
struct Casting {
  const v1::LeverEffect* plan;
  std::vector<Moves> levers;
};

bool is_same_lever(const v1::LeverStep& a, const v1::LeverStep& b) {
  return a.key() == b.key() && a.steps() == b.steps();
}

std::vector<Casting> castings_of(const v1::StudyResult& study) {
  std::vector<Casting> castings;
  for (const v1::LeverEffect& effect : study.lever_effects()) {
    if (!effect.has_step()) {
      castings.push_back({&effect, {}});
      continue;
    }
    auto& levers = castings.back().levers;
    const auto same = std::ranges::find_if(levers, [&](const Moves& moves) {
      return is_same_lever(moves.front()->step(), effect.step());
    });
    (same == levers.end() ? levers.emplace_back() : *same).push_back(&effect);
  }

  for (Casting& casting : castings)
    for (Moves& moves : casting.levers)
      std::ranges::sort(moves, {}, [](const auto* effect) { return effect->step().from_s(); });
  return castings;
}

/// What a lever does in one casting that is moved now.
class MovedNow {
public:
  /// @param moves  of the lever, at least one
  MovedNow(const Moves& moves, double now_s, double end_s) : moves_(moves) {
    for (const v1::LeverEffect* move : moves) from_s_.push_back(move->step().from_s());
    // Moved at the end it does nothing.
    from_s_.push_back(std::max(end_s, from_s_.back()));
    now_s_ = std::clamp(now_s, from_s_.front(), from_s_.back());
  }

  /// @param figure  of one run [any unit]; NaN where it is not known
  template <typename Figure>
  double value(const Figure& figure) const {
    std::vector<double> values;
    for (const v1::LeverEffect* move : moves_) values.push_back(figure(*move));
    values.push_back(0.0);
    return values::at_instants({now_s_}, from_s_, values).front();
  }

  /// Adds the findings of the last run that was moved before, and of the next one.
  void add_worse(std::vector<std::string>& codes) const {
    for (std::size_t i = 0; i < moves_.size(); ++i) {
      const bool is_around = now_s_ <= from_s_[i + 1] && (i == 0 || now_s_ >= from_s_[i - 1]);
      if (!is_around) continue;
      for (const std::string& code : moves_[i]->worse())
        if (std::ranges::find(codes, code) == codes.end()) codes.push_back(code);
    }
  }

private:
  const Moves& moves_;
  std::vector<double> from_s_;  ///< (run), then the end
  double now_s_;
};

/// An effect in castings whose plans curl differently [m].
struct Sample {
  std::vector<double> curl_m;    ///< (casting) of the plan
  std::vector<double> effect_m;  ///< (casting)
};

/// Half the width of a band of nine in ten, in standard deviations that were estimated: the
/// quantile of Student's t (Abramowitz and Stegun 1964, 26.7.5, two terms).
double student_quantile(double degrees_of_freedom) {
  const double z = nine_of_ten;
  return z + (z * z * z + z) / (4.0 * degrees_of_freedom);
}

/// The effect in a casting whose curl is known to some extent, by the straight line through those
/// of the sample (least squares). The band holds the scatter about the line and the error of the
/// line, the band of the curl, and the error of the mesh. NaN: too few castings.
v1::ExpectedCurl predicted(const Sample& sample, const v1::ExpectedCurl& curl) {
  v1::ExpectedCurl effect;
  const auto count = static_cast<Eigen::Index>(sample.curl_m.size());
  if (count < fewest_castings) {
    effect.set_curl_m(NAN);
    effect.set_lower_m(NAN);
    effect.set_upper_m(NAN);
    return effect;
  }

  const auto x = Eigen::ArrayXd::Map(sample.curl_m.data(), count);
  const auto y = Eigen::ArrayXd::Map(sample.effect_m.data(), count);
  const Eigen::ArrayXd off = x - x.mean();
  const double spread = off.square().sum();
  const double slope = spread > 0.0 ? (off * (y - y.mean())).sum() / spread : 0.0;
  const double degrees = static_cast<double>(count - 2);
  const double scatter2 = (y - y.mean() - slope * off).square().sum() / degrees;

  const double distance = curl.curl_m() - x.mean();
  const double mean = y.mean() + slope * distance;
  const double of_line =
      1.0 / static_cast<double>(count) + (spread > 0.0 ? distance * distance / spread : 0.0);
  const double of_curl = slope * 0.5 * (curl.upper_m() - curl.lower_m()) / nine_of_ten;
  const double of_mesh = std::hypot(mesh_share * mean, least_error_m);
  const double half = std::hypot(student_quantile(degrees) * std::sqrt(scatter2 * (1.0 + of_line)),
                                 nine_of_ten * of_curl, nine_of_ten * of_mesh);
  effect.set_curl_m(mean);
  effect.set_lower_m(mean - half);
  effect.set_upper_m(mean + half);
  return effect;
}

bool lowers(const v1::ExpectedCurl& curl) {
  return curl.curl_m() <= -least_gain_m && curl.upper_m() < 0.0;
}

bool raises(const v1::ExpectedCurl& curl) {
  return curl.curl_m() >= least_gain_m && curl.lower_m() > 0.0;
}

/// Whether it lowers a curl, whatever findings it brings.
bool gains(const v1::LeverAhead& lever) {
  return std::ranges::any_of(lever.curls(), lowers) && std::ranges::none_of(lever.curls(), raises);
}

/// The most by which a curl falls [m].
double gain_m(const v1::LeverAhead& lever) {
  double gain_m = 0.0;
  for (const v1::ExpectedCurl& curl : lever.curls()) gain_m = std::max(gain_m, -curl.curl_m());
  return gain_m;
}

/// The curl at a gauge at the end of the casting, as it is forecast.
v1::ExpectedCurl curl_at_end(const v1::ForecastCurl& forecast) {
  v1::ExpectedCurl curl;
  curl.set_curl_m(*forecast.curl_m().rbegin());
  curl.set_lower_m(*forecast.lower_m().rbegin());
  curl.set_upper_m(*forecast.upper_m().rbegin());
  return curl;
}

/// A lever that is moved now, in the casting under way.
/// @param monitors  of the study, by gauge
v1::LeverAhead lever_ahead(const v1::LeverStep& step, const std::vector<Casting>& castings,
                           const std::vector<int>& monitors, const v1::Forecast& forecast) {
  std::vector<Sample> samples(monitors.size());
  std::vector<std::string> worse;
  double least_shell_m = INFINITY;

  for (const Casting& casting : castings) {
    const auto moves = std::ranges::find_if(casting.levers, [&](const Moves& other) {
      return is_same_lever(other.front()->step(), step);
    });
    if (moves == casting.levers.end()) continue;
    const MovedNow moved(*moves, forecast.time_s(), *forecast.curls(0).time_s().rbegin());
    moved.add_worse(worse);

    const double shell_m = moved.value([](const v1::LeverEffect& effect) {
      return effect.has_least_shell_m() ? effect.least_shell_m() : NAN;
    });
    if (std::isfinite(shell_m)) least_shell_m = std::min(least_shell_m, shell_m);
    for (std::size_t gauge = 0; gauge < monitors.size(); ++gauge) {
      const int monitor = monitors[gauge];
      const double effect_m =
          moved.value([&](const v1::LeverEffect& effect) { return effect.curl_m(monitor); });
      if (!std::isfinite(effect_m)) continue;
      samples[gauge].curl_m.push_back(casting.plan->curl_m(monitor));
      samples[gauge].effect_m.push_back(effect_m);
    }
  }

  v1::LeverAhead lever;
  lever.set_key(step.key());
  lever.set_words(step.words());
  for (std::size_t gauge = 0; gauge < monitors.size(); ++gauge)
    *lever.add_curls() =
        predicted(samples[gauge], curl_at_end(forecast.curls(static_cast<int>(gauge))));
  if (std::isfinite(least_shell_m)) lever.set_least_shell_m(least_shell_m);
  for (std::string& code : worse) lever.add_worse(std::move(code));
  lever.set_is_advised(gains(lever) && lever.worse().empty());
  return lever;
}

/// "use 20 % less water than planned from now on: corner -1.4 mm at the end (-2.1 to -0.8), least
/// shell -0.3 mm"
std::string sentence_of(const v1::LeverAhead& lever, const v1::Following& following) {
  std::string text = fmt::format("{} than planned from now on:", lever.words());
  for (int i = 0; i < lever.curls_size(); ++i) {
    const v1::ExpectedCurl& curl = lever.curls(i);
    text += fmt::format(" {} {:+.1f} mm at the end ({:+.1f} to {:+.1f}),",
                        following.gauges(i).monitor(), 1e3 * curl.curl_m(), 1e3 * curl.lower_m(),
                        1e3 * curl.upper_m());
  }
  return lever.has_least_shell_m()
             ? text + fmt::format(" least shell {:+.1f} mm", 1e3 * lever.least_shell_m())
             : text.substr(0, text.size() - 1);
}

/// Why there is no advice: no lever does enough, or it makes a finding worse.
std::string sentence_without_advice(const v1::Forecast& forecast, const v1::Following& following) {
  std::vector<std::string> gauges;
  for (const v1::Gauge& gauge : following.gauges()) gauges.push_back(gauge.monitor());
  const std::string curl = fmt::format("the {} by more than {:.0f} mm",
                                       fmt::join(gauges, " or the "), 1e3 * least_gain_m);

  const auto costly = std::ranges::find_if(forecast.levers(), gains);
  if (costly == forecast.levers().end()) return fmt::format("no lever lowers {} any more", curl);
  return fmt::format("no lever lowers {} without making a finding worse: \"{}\" does so for {}",
                     curl, costly->words(), fmt::join(costly->worse(), ", "));
}

}  // namespace

void add_advice(const v1::StudyResult& study, const v1::Following& following, v1::Forecast& to) {
  if (study.study().state() == v1::STUDY_RUNNING || to.curls().empty()) return;
  const std::vector<Casting> castings = castings_of(study);
  if (castings.size() < fewest_castings) return;

  std::vector<int> monitors;
  for (const v1::Gauge& gauge : following.gauges()) {
    const auto found = std::ranges::find(study.monitors(), gauge.monitor());
    if (found == study.monitors().end()) return;  // the study of another case
    monitors.push_back(static_cast<int>(found - study.monitors().begin()));
  }

  for (const Moves& moves : castings.front().levers)
    *to.add_levers() = lever_ahead(moves.front()->step(), castings, monitors, to);
  std::ranges::stable_sort(*to.mutable_levers(), [](const auto& a, const auto& b) {
    return a.is_advised() != b.is_advised() ? a.is_advised() : gain_m(a) > gain_m(b);
  });

  for (const v1::LeverAhead& lever : to.levers())
    if (lever.is_advised()) to.add_advice(sentence_of(lever, following));
  if (to.advice().empty()) to.add_advice(sentence_without_advice(to, following));
}

}  // namespace dccast::studies
