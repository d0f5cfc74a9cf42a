// What castings of a line teach, on plants whose truth is hidden from the method (docs/lines.md).
//
//   dccast-line-posterior RUNS.csv [SHARE [PLANTS]]
//
// RUNS.csv is written by line_posterior.py: danger (0 or 1), curl [m] or nan, then the place on
// each axis, 0 to 1, without a header. The method knows the first SHARE of the runs, 0.5.
// The truth of a plant is a surface over all of them, with an error of its own of the size that
// runs left out have. Each plant has cast 30 castings soundly and typed five curls, 3 mm off by
// hand.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "core/statistics/gaussian_process.hpp"
#include "core/statistics/line_posterior.hpp"
#include "core/statistics/robust_search.hpp"
#include "core/statistics/sampling.hpp"

namespace {

using namespace dccast::statistics;

constexpr double scatter = 0.2, hand_m = 3e-3;
constexpr int sound_castings = 30, curls_typed = 5, true_castings = 400;

struct Runs {
  std::vector<bool> danger;
  std::vector<double> curl;  // [m], NaN where there is none
  Eigen::MatrixXd places;    // (run, axis)
};

Runs read(const std::string& path, std::size_t most) {
  std::ifstream file(path);
  Runs runs;
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line) && rows.size() < most;) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream words(line);
    std::vector<double> row;
    for (std::string word; words >> word;) row.push_back(std::stod(word));
    runs.danger.push_back(row[0] > 0.5);
    runs.curl.push_back(row[1]);
    rows.emplace_back(row.begin() + 2, row.end());
  }
  runs.places = stack_rows(rows);
  return runs;
}

double left_out(const GaussianProcess& process) {
  const auto& errors = process.left_out_errors();
  return errors.norm() / std::sqrt(static_cast<double>(errors.size()));
}

/// Surfaces of danger and curl over some runs.
struct Surfaces {
  explicit Surfaces(const Runs& runs)
      : danger(runs.places, runs.danger), curl(process_of(runs)), curl_error(left_out(curl)) {}

  static GaussianProcess process_of(const Runs& runs) {
    std::vector<Eigen::RowVectorXd> places;
    std::vector<double> values;
    for (Eigen::Index i = 0; i < runs.places.rows(); ++i)
      if (std::isfinite(runs.curl[i])) {
        places.push_back(runs.places.row(i));
        values.push_back(runs.curl[i]);
      }
    return {stack_rows(places), Eigen::VectorXd::Map(values.data(), values.size())};
  }

  LineModel model() const {
    LineModel made{.inputs = 0, .dangers = {}, .curl = {}, .scatter = scatter};
    made.dangers.push_back(
        {[this](const Eigen::MatrixXd& places) { return danger.answer(places); }, danger.error()});
    made.curl = {[this](const Eigen::MatrixXd& places) { return curl.means(places); }, curl_error};
    return made;
  }

  Classifier danger;
  GaussianProcess curl;
  double curl_error;
};

using Random = std::mt19937_64;

/// A plant and what it casts.
class Plant {
public:
  /// @param broken  its curls and dangers follow the data in the opposite order
  Plant(const Surfaces& truth, Eigen::Index axes, bool broken, Random& random)
      : truth_(truth), broken_(broken) {
    data_ = Eigen::RowVectorXd::NullaryExpr(axes, [&] { return normal(random); });
    for (double& error : errors_) error = normal(random);
  }

  struct Castings {
    Eigen::VectorXd danger, curl;  // 0 or 1; [m]
  };
  Castings cast(int number, Random& random) const {
    const double kept = std::sqrt(1.0 - scatter), anew = std::sqrt(scatter);
    Eigen::MatrixXd places(number, data_.size());
    for (Eigen::Index i = 0; i < number; ++i)
      for (Eigen::Index j = 0; j < data_.size(); ++j)
        places(i, broken_ ? data_.size() - 1 - j : j) =
            normal_below(kept * data_(j) + anew * normal(random));
    Castings castings{truth_.danger.answer(places), truth_.curl.means(places)};
    for (double& danger : castings.danger) {
      const double error = kept * errors_[0] + anew * normal(random);
      danger = danger + truth_.danger.error() * error > 0.0 ? 1.0 : 0.0;
    }
    for (double& curl : castings.curl)
      curl += truth_.curl_error * (kept * errors_[1] + anew * normal(random));
    return castings;
  }

private:
  const Surfaces& truth_;
  bool broken_;
  Eigen::RowVectorXd data_;
  double errors_[2];
};

LineRecord sound(double count) {
  return {.dangers = {false}, .count = count};
}

/// Figures of one way to record castings, over all plants.
struct Tally {
  int danger_held = 0, unanswered = 0, named = 0;
  double danger = 0.0, width = 0.0, held = 0.0, seconds = 0.0;

  void print(const std::string& name, double width_before, int plants) const {
    fmt::print("| {} | {:.1f} % | {} of {} | {:.1f} mm, {:.0f} % | {:.0f} % | {} | {:.2f} s |\n",
               name, 100.0 * danger / plants, danger_held, plants, 1e3 * width / plants,
               100.0 * width / plants / width_before, 100.0 * held / plants, named,
               seconds / plants);
    if (unanswered > 0) fmt::print("  {} plants without an answer\n", unanswered);
  }
};

/// Asks about the next casting, and compares with what the plant goes on to cast.
void ask(const LineModel& model, const std::vector<LineRecord>& records,
         const Plant::Castings& later, Tally& tally) {
  const auto begin = std::chrono::steady_clock::now();
  const LinePosterior next = next_casting(model, records, 7);
  tally.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  const double share = later.danger.mean();
  tally.danger += next.danger;
  tally.danger_held += share >= next.danger_low - 0.005 && share <= next.danger_high + 0.005;
  tally.width += next.curl_high - next.curl_low;
  tally.held += (later.curl.array() >= next.curl_low && later.curl.array() <= next.curl_high)
                    .cast<double>()
                    .mean();
  tally.unanswered += next.effective_draws < 30.0;
  tally.named += records.empty() ? 0 : next.wrong(next.wrong.size() - 1) > 0.5;
}

void study(const Surfaces& method, const Surfaces& truth, Eigen::Index axes, int plants,
           bool broken) {
  LineModel model = method.model();
  model.inputs = static_cast<int>(axes);
  const LinePosterior before = next_casting(model, {}, 7);
  const double width = before.curl_high - before.curl_low;
  const double middle = before.curl_median;

  Random random(broken ? 2 : 1);
  Tally prior, given, bled, wrong_curl, mistyped;
  int tried = 0;
  for (int found = 0; found < plants; ++tried) {
    const Plant plant(truth, axes, broken, random);
    const auto earlier = plant.cast(sound_castings, random);
    // In daily life it is sound, and it does not stand in the middle of what was thought possible.
    const bool is_middling = std::abs(earlier.curl.mean() - middle) < 0.2 * width;
    if (earlier.danger.sum() > 0.0 || is_middling) continue;
    ++found;

    const auto later = plant.cast(true_castings, random);
    std::vector<LineRecord> records{sound(sound_castings)};
    for (int i = 0; i < curls_typed; ++i)
      records.push_back({.dangers = {std::nullopt},
                         .count = 1.0,
                         .curl = earlier.curl(i) + hand_m * normal(random),
                         .curl_noise = hand_m});
    ask(model, {}, later, prior);
    ask(model, records, later, given);

    auto with = records;
    with.push_back({.dangers = {true}});
    ask(model, with, later, bled);
    with.back() = {.dangers = {std::nullopt},
                   .count = 1.0,
                   .curl = earlier.curl(0) + 40e-3,
                   .curl_noise = hand_m};
    ask(model, with, later, wrong_curl);
    with.back() = sound(1.0);
    ask(model, with, later, mistyped);
  }

  fmt::print("\n{}: {} plants of {} drawn\n\n", broken ? "broken model" : "the model", plants,
             tried);
  fmt::print(
      "| records | dangers | plants in the band | curl band, of before | it holds | last "
      "record named | time |\n|---|---|---|---|---|---|---|\n");
  prior.print("none", width, plants);
  given.print("30 sound, 5 curls", width, plants);
  bled.print("and one bleed-out", width, plants);
  wrong_curl.print("and a curl that is 40 mm wrong", width, plants);
  mistyped.print("and a bleed-out typed as sound", width, plants);
}

}  // namespace

int main(int count, char** words) {
  if (count < 2 || count > 4) {
    fmt::print(stderr, "usage: dccast-line-posterior RUNS.csv [SHARE [PLANTS]]\n");
    return 2;
  }
  const double share = count > 2 ? std::stod(words[2]) : 0.5;
  const Runs all = read(words[1], SIZE_MAX);
  const auto known = static_cast<std::size_t>(share * static_cast<double>(all.danger.size()));
  const Surfaces truth(all), method(read(words[1], known));
  fmt::print(
      "{} runs over {} data, {:.0f} % with a danger; dangers misjudged {:.0f} %, curl off by "
      "{:.1f} mm; of the {} that the method knows {:.0f} %, {:.1f} mm\n",
      all.danger.size(), all.places.cols(),
      100.0 * static_cast<double>(std::ranges::count(all.danger, true)) /
          static_cast<double>(all.danger.size()),
      100.0 * truth.danger.misjudged(), 1e3 * truth.curl_error, known,
      100.0 * method.danger.misjudged(), 1e3 * method.curl_error);
  const int plants = count > 3 ? std::stoi(words[3]) : 20;
  study(method, truth, all.places.cols(), plants, false);
  study(method, truth, all.places.cols(), plants, true);
  return 0;
}
