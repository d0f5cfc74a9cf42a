#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "core/casting/case/case_check.hpp"
#include "core/casting/simulation.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/usual_options.hpp"
#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::casting::testing {

/// The paper's alloy in a few cells: ten seconds of hold, twenty of casting.
inline Case small_casting(mesh::ElementKind element = mesh::ElementKind::p1) {
  Case c;
  c.title = "a small casting";
  c.source_json = R"({"title": "a small casting"})";

  c.section.half_width = 0.28;
  c.section.initial_depth = 0.10;
  c.section.element = element;
  c.section.columns = 7;
  c.section.rows = 6;
  c.section.side_cell = 0.012;
  c.section.bottom_cell = 0.010;
  c.section.wide_side_cell = 3e-3;
  c.section.growth_cell = 0.008;
  c.section.growth = true;

  c.alloy = thermal::testing::casting_alloy();
  c.alloy.name = "paper";
  c.alloy.coherency = 649.0;
  c.alloy.hot_tears = {.start = 0.9, .end = 0.98, .arm_spacing = 80e-6};
  c.alloy.young_modulus = {Abscissa::temperature, {126.9, 326.9, 526.9}, {67e9, 58e9, 40e9}};
  c.alloy.poisson_ratio = {Abscissa::temperature, {126.9, 326.9, 526.9}, {0.3134, 0.3448, 0.45}};
  c.alloy.creep = material::NortonHoffConstants{4.0e12, 15.72e6, 37.3 * 4184.0, 6.0};

  c.schedule.hold = 10.0;
  c.schedule.casting_speed = Curve(1e-3);
  c.schedule.casting_temperature = Curve(680.0);
  c.schedule.water_flow = Curve(2e-3);
  c.cooling = thermal::testing::casting_cooling();

  c.thermal.tolerance = 1e-11;
  c.thermal.maximum_iterations = 60;
  c.mechanics.enabled = true;
  // Forces are judged against those that act, which are a thousand times the weight: at 1e-7 the
  // reaction is off by up to 5e-4 of it.
  c.mechanics.options = dccast::testing::usual_options(1e-9);

  c.coupling.gap_feedback = true;
  c.time.minimum_step = 1e-3;
  c.time.end = 20.0;
  c.time.step = {Abscissa::time, {-10.0, -0.001, 0.0, 4.0, 4.001}, {1.0, 1.0, 0.25, 0.25, 1.0}};
  c.monitors = {{"corner", 0.28, 0.0}, {"centre", 0.0, 0.0}, {"not yet poured", 0.1, 0.115}};

  c.output = {.frame_interval = 5.0, .stresses = true};
  // After so short a hold the thin shell at the corner turns by more than the usual 10 degrees.
  c.validity = {.maximum_rotation = 30.0 * std::numbers::pi / 180.0, .maximum_slip = 0.02};

  c.plausibility.minimum_superheat = 5.0;
  c.plausibility.minimum_shell = 5e-3;
  c.plausibility.maximum_mush_strain = 0.005;
  c.plausibility.maximum_sump_share = 0.95;

  c.limits = {.maximum_nodes = 400000, .maximum_steps = 200000};
  return c;
}

/// "FIELD: MESSAGE" of each fault, for the message of a failed test.
inline std::string all(const Faults& faults) {
  std::string text;
  for (const Fault& f : faults.list()) text += f.field + ": " + f.message + "\n";
  return text;
}

/// Stores every report and gives a chosen order after a chosen step.
class Recorder : public StepObserver {
public:
  std::vector<results::StepReport> reports;
  std::vector<results::StepReport> before;  ///< of the earlier part of a resumed run
  std::int64_t resumed_from = -1;
  std::vector<std::string> messages;
  std::int64_t act_after = -1;  ///< step after which `then` is ordered
  Order then = Order::go_on;
  bool die = false;  ///< leave by an exception instead, as if the process were killed

  struct Killed {};

  Order on_step(const results::StepReport& report) override {
    reports.push_back(report);
    if (report.step != act_after) return Order::go_on;
    if (die) throw Killed{};
    return then;
  }
  std::vector<results::StepReport> reported_steps(std::int64_t step) override {
    const auto count = std::min(before.size(), static_cast<std::size_t>(step));
    return {before.begin(), before.begin() + static_cast<std::ptrdiff_t>(count)};
  }
  void on_resumed(std::int64_t step, double) override { resumed_from = step; }
  void on_message(std::string_view text) override { messages.emplace_back(text); }
};

/// Whether two steps agree bit by bit in all but the seconds of the processor.
inline bool equal_except_timing(results::StepReport a, results::StepReport b) {
  // A monitor above the metal is NaN, which is not equal to itself: compare its bits.
  const auto bits = [](const auto& points) {
    std::vector<std::uint64_t> numbers;
    for (const auto& point : points)
      for (const double value : point) numbers.push_back(std::bit_cast<std::uint64_t>(value));
    return numbers;
  };
  const bool same_monitors =
      bits(a.monitor_displacement) == bits(b.monitor_displacement) &&
      bits(std::array{a.monitor_temperature}) == bits(std::array{b.monitor_temperature});

  a.monitor_displacement = b.monitor_displacement = {};
  a.monitor_temperature = b.monitor_temperature = {};
  a.solver_seconds = b.solver_seconds;
  a.process_seconds = b.process_seconds;
  return same_monitors && a == b;
}

inline std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Kills a run after its 18th step, which has a checkpoint every four, and lets it go on.
inline void expect_the_same_bytes_after_a_kill(Case c) {
  const TemporaryFolder whole, killed;
  Recorder first, second, uninterrupted;
  c.checkpoint.every_steps = 4;
  EXPECT_EQ(run(c, {whole / "", false}, uninterrupted).end, RunEnd::succeeded);

  first.act_after = 18;
  first.die = true;
  EXPECT_THROW(run(c, {killed / "", false}, first), Recorder::Killed);

  second.before = first.reports;
  EXPECT_EQ(run(c, {killed / "", true}, second).end, RunEnd::succeeded);
  EXPECT_EQ(second.resumed_from, 16);
  EXPECT_TRUE(bytes_of(killed / "results.h5") == bytes_of(whole / "results.h5"));
  EXPECT_TRUE(equal_except_timing(second.reports.back(), uninterrupted.reports.back()));
}

}  // namespace dccast::casting::testing
