#include "server/studies/mould_opening.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace dccast::studies {
namespace {

using frames::SteadyFace;

constexpr double length = 0.66, wanted = 0.285;
const MouldTarget half_a_millimetre{wanted, 0.5e-3, {length, 0.066, wanted, 1.3 * wanted}};

/// Contraction at a place of a mould that is open by so much in the middle, here, and on average.
struct Place {
  double x, opening, middle, mean;
};
using Law = std::function<double(const Place&)>;
using Opening = std::function<double(double x)>;

/// 1.9 % at the narrow face, 7 % in the middle: a plant's mould (docs/contraction.md).
double of_plants(const Place& at) {
  const double share = at.x / length;
  return wanted * (0.07 - 0.051 * share * share);
}

/// Contraction that follows the opening: half of all that it is opened further is lost again.
double that_follows(const Place& at) {
  return of_plants(at) + 0.5 * (at.opening - wanted);
}

/// Contraction that bends with the face: it pulls in more where the mould bulges beyond its mean.
double that_bends(const Place& at) {
  return of_plants(at) + 0.3 * (at.opening - at.mean) + 0.1 * (at.middle - wanted);
}

SteadyFace cast(const Opening& opening, const Law& law) {
  SteadyFace trial;
  double mean = 0.0;
  constexpr int nodes = 23;
  for (int i = 0; i < nodes; ++i) mean += opening(length * i / (nodes - 1)) / nodes;
  for (int i = 0; i < nodes; ++i) {
    const double x = length * i / (nodes - 1);
    trial.x_m.push_back(x);
    trial.mould_m.push_back(opening(x));
    trial.cold_m.push_back(opening(x) - law({x, opening(x), opening(0.0), mean}));
  }
  return trial;
}

SteadyFace cast_in_rectangle(const Law& law) {
  return cast([](double) { return wanted; }, law);
}

void expect_sound(const MouldOpening& o, const OpeningBounds& bounds) {
  constexpr double round_off = 1e-9;
  EXPECT_EQ(o.x[0], 0.0);
  EXPECT_EQ(o.x[3], bounds.length);
  EXPECT_EQ(o.half[0], o.half[1]) << "flat in the middle";
  for (std::size_t i = 0; i + 1 < 4; ++i) {
    EXPECT_GE(o.x[i + 1] - o.x[i], bounds.spacing - round_off);
    EXPECT_GE(o.half[i], o.half[i + 1] - round_off);
  }
  EXPECT_LE((o.half[3] - o.half[2]) / (o.x[3] - o.x[2]),
            (o.half[2] - o.half[1]) / (o.x[2] - o.x[1]) + round_off);
  for (const double half : o.half) {
    EXPECT_GE(half, bounds.least - round_off);
    EXPECT_LE(half, bounds.most + round_off);
  }
  for (const std::size_t i : {1, 2})
    EXPECT_NEAR(1e3 * o.x[i], std::round(1e3 * o.x[i]), 1e-6) << "whole millimetres";
}

/// Casts until the rule finds no further opening to try. @return all trials
std::vector<SteadyFace> search(const Law& law, const MouldTarget& target, SteadyFace first) {
  std::vector<SteadyFace> history{std::move(first)};
  while (history.size() < 12) {
    const auto next = next_opening(history, target);
    if (!next) break;
    expect_sound(*next, target.bounds);
    history.push_back(cast([&](double x) { return next->at(x); }, law));
  }
  return history;
}

double reached(const std::vector<SteadyFace>& history) {
  return best_trial(history, wanted)->residual_m(wanted);
}

TEST(NextOpening, AContractionThatDoesNotDependOnTheMouldIsMetAtOnce) {
  const auto history = search(of_plants, half_a_millimetre, cast_in_rectangle(of_plants));
  EXPECT_EQ(history.size(), 2u);
  EXPECT_LE(reached(history), 0.5e-3);
}

TEST(NextOpening, AContractionThatFollowsTheOpeningIsMetByTheSecant) {
  const auto history = search(that_follows, half_a_millimetre, cast_in_rectangle(that_follows));
  EXPECT_LE(reached(history), 0.5e-3);
  EXPECT_LE(history.size(), 3u) << "the plain correction halves what is left, from 20 mm: 7 runs";
}

TEST(NextOpening, AContractionThatBendsWithTheFaceIsMetInFewRuns) {
  const auto history = search(that_bends, half_a_millimetre, cast_in_rectangle(that_bends));
  EXPECT_LE(reached(history), 0.5e-3);
  EXPECT_LE(history.size(), 5u);
}

TEST(NextOpening, AMouldThatIsOpenTooFarIsClosed) {
  const auto history = search(that_bends, half_a_millimetre,
                              cast([](double x) { return 0.32 - 0.02 * x; }, that_bends));
  EXPECT_LE(reached(history), 0.5e-3);
  EXPECT_LE(history.size(), 5u);
}

TEST(NextOpening, EndsWithinTheToleranceAndWhereThreeSegmentsComeNoNearer) {
  const auto history = search(of_plants, half_a_millimetre, cast_in_rectangle(of_plants));
  EXPECT_FALSE(next_opening(history, half_a_millimetre));
  EXPECT_FALSE(next_opening({}, half_a_millimetre)) << "nothing is known";
  MouldTarget impossible = half_a_millimetre;
  impossible.tolerance = 1e-6;
  const auto settled = search(of_plants, impossible, cast_in_rectangle(of_plants));
  EXPECT_LT(settled.size(), 6u) << "three segments come no nearer";
  EXPECT_GT(reached(settled), 1e-6);
  EXPECT_LE(reached(settled), 0.5e-3);
}

TEST(NextOpening, KeepsToItsBounds) {
  MouldTarget narrow = half_a_millimetre;
  narrow.bounds.most = 0.295;
  narrow.bounds.spacing = 0.2;
  const auto history = search(of_plants, narrow, cast_in_rectangle(of_plants));
  EXPECT_GT(reached(history), 0.5e-3) << "bounds that leave out the answer";
}

TEST(NextOpening, AnswersOfTheSameTrialsAreTheSame) {
  const std::vector<SteadyFace> history{cast_in_rectangle(that_bends)};
  EXPECT_EQ(next_opening(history, half_a_millimetre), next_opening(history, half_a_millimetre));
}

std::vector<double> steps_to(double end, int count) {
  std::vector<double> x;
  for (int i = 0; i <= count; ++i) x.push_back(end * i / count);
  return x;
}

TEST(NearestOpening, FindsAnOpeningOfThreeSegmentsAgain) {
  const MouldOpening opening{{0.0, 0.2, 0.42, length}, {0.303, 0.303, 0.298, 0.291}};
  const std::vector<double> x = steps_to(length, 66);
  std::vector<double> half;
  for (const double at : x) half.push_back(opening.at(at));
  const MouldOpening found = nearest_opening(x, half, half_a_millimetre.bounds);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(found.x[i], opening.x[i], 1e-9);
    EXPECT_NEAR(found.half[i], opening.half[i], 1e-9);
  }
}

TEST(NearestOpening, IsConvexWhateverItIsFittedTo) {
  const std::vector<double> x = steps_to(length, 40);
  for (const double phase : {0.0, 1.0, 2.0, 3.0, 4.0, 5.0}) {
    std::vector<double> hollow, wavy;
    for (const double at : x) {
      hollow.push_back(0.30 + 0.01 * std::cos(phase + 3.0 * at));
      wavy.push_back(0.29 + 0.02 * std::sin(phase + 20.0 * at));
    }
    expect_sound(nearest_opening(x, hollow, half_a_millimetre.bounds), half_a_millimetre.bounds);
    expect_sound(nearest_opening(x, wavy, half_a_millimetre.bounds), half_a_millimetre.bounds);
  }
}

}  // namespace
}  // namespace dccast::studies
