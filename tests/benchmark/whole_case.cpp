// The whole start stage, 145 s of casting after a hold, by every element and algorithm that an
// engineer would choose. Figures are seconds of processors.

#include <benchmark/benchmark.h>

#include <filesystem>

#include "core/casting/simulation.hpp"
#include "dccast/v1/case.pb.h"
#include "tests/support/load_case.hpp"

namespace {

using namespace dccast;

struct Silent : casting::StepObserver {
  casting::Order on_step(const results::StepReport& report) override {
    last = report;
    iterations += report.iterations;
    heat_iterations += report.heat_iterations;
    factorizations += report.factorizations;
    solves += report.solves;
    ++steps;
    mechanical_steps += report.iterations > 0 ? 1 : 0;
    return casting::Order::go_on;
  }
  void on_resumed(std::int64_t, double) override {}
  void on_message(std::string_view) override {}
  results::StepReport last;
  double heat_iterations = 0.0, factorizations = 0.0, solves = 0.0, steps = 0.0;
  double iterations = 0.0, mechanical_steps = 0.0;
};

void run_case(benchmark::State& state, const casting::Case& c, int threads = 1) {
  const auto folder = std::filesystem::temp_directory_path() / "dccast-benchmark";
  for (auto _ : state) {
    std::filesystem::create_directories(folder);
    Silent observer;
    benchmark::DoNotOptimize(casting::run(c, {folder, false}, observer, threads));
    state.counters["solver_s"] = observer.last.solver_seconds;
    state.counters["iterations_per_step"] = observer.iterations / observer.mechanical_steps;
    state.counters["heat_its"] = observer.heat_iterations / observer.steps;
    state.counters["factors"] = observer.factorizations;
    state.counters["solves"] = observer.solves;
    state.counters["steps"] = observer.steps;
    state.counters["curl_corner_mm"] = 1e3 * observer.last.monitor_displacement.at(0).back();
    state.counters["elements_at_end"] = static_cast<double>(observer.last.elements);
    std::filesystem::remove_all(folder);
  }
}

void start_2d_thickness(benchmark::State& state) {
  casting::Case c = support::load_case("start-2d-thickness");
  support::take_paper_size(c);
  c.section.element = state.range(0) == 0 ? mesh::ElementKind::p1 : mesh::ElementKind::q1;
  c.section.refinement = static_cast<int>(state.range(1));
  c.mechanics.options.algorithm =
      state.range(2) == 0 ? mechanics::Algorithm::newton : mechanics::Algorithm::vnbm;
  run_case(state, c);
}
BENCHMARK(start_2d_thickness)
    ->ArgNames({"q1", "refinement", "vnbm"})
    ->Args({0, 1, 0})
    ->Args({1, 1, 0})
    ->Args({0, 1, 1})
    ->Args({0, 2, 0})
    ->Args({1, 2, 0})
    ->Args({1, 4, 0})
    ->Unit(benchmark::kSecond)
    ->Iterations(1);

/// The quarter slab by one thread and by two: wall seconds beside those of processors.
void start_3d(benchmark::State& state) {
  const auto quality = state.range(0) == 0 ? v1::DRAFT : v1::ENGINEERING;
  run_case(state, support::load_case("start-3d", quality), static_cast<int>(state.range(1)));
}
BENCHMARK(start_3d)
    ->ArgNames({"engineering", "threads"})
    ->ArgsProduct({{0, 1}, {1, 2}})
    ->Unit(benchmark::kSecond)
    ->UseRealTime()
    ->Iterations(1);

}  // namespace
