// A quarter slab that nothing holds contracts by its thermal strain alone.
#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/slab_mesh.hpp"
#include "core/results/hdf5_file.hpp"
#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_quarter_slab.hpp"

namespace dccast::casting {
namespace {

using testing::Recorder;
using testing::small_quarter_slab;
using testing::small_rounded_slab;

constexpr double hot = 600.0, cold = 20.0, duration = 29.0;  // [°C], [°C], [s]

double temperature_at(double time) {
  return hot + (cold - hot) * time / duration;
}

/// The same temperature everywhere, falling steadily.
void write_temperature(int nodes, const std::filesystem::path& path) {
  const std::vector<double> time{0.0, duration};
  std::vector<double> temperature(std::size_t(2 * nodes), hot);
  std::fill(temperature.begin() + nodes, temperature.end(), cold);
  auto file = results::hdf5::File::create(path);
  file.write("/time_s", time, "s", "time");
  file.write("/temperature_c", {time.size(), std::size_t(nodes)}, temperature, "degC",
             "temperature");
  file.close();
}

/// Free strain from the start to a time: the cube root of the ratio of densities, against the
/// length at the liquidus.
double free_strain(const material::AlloyCard& alloy, double time) {
  const auto stretch = [&](double t) {
    return std::cbrt(alloy.density(alloy.liquidus) / alloy.density(t));
  };
  return stretch(temperature_at(time)) - stretch(hot);
}

/// Independent of the shape of the slab.
void expect_free_contraction(Case c) {
  const TemporaryFolder folder;
  c.section.growth = false;
  c.schedule.hold = 0.0;
  c.mechanics.options.gravity = 0.0;
  c.mechanics.options.contact = false;  // without weight nothing keeps it on the block
  c.mechanics.options.tolerance = 1e-10;
  c.time.end = duration;
  c.time.step = Curve(1.0);
  c.output.frame_interval = 5.0;
  c.thermal.file = folder / "temperature.h5";
  c.monitors = {{"wide face", 0.0, 0.15, 0.0}};
  write_temperature(mesh::SlabMesh3D(c.section).heat_mesh().nodes(), c.thermal.file);
  ASSERT_TRUE(check(c).faults.empty()) << testing::all(check(c).faults);
  Recorder recorder;
  const RunOutcome outcome = run(c, {folder / "", false}, recorder);
  ASSERT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
  ASSERT_EQ(recorder.reports.size(), 29u);
  const results::ResultReader reader(folder / "results.h5");
  for (std::size_t f = 0; f < reader.frames(); ++f) {
    const results::Frame frame = reader.frame(f);
    const double strain = free_strain(c.alloy, frame.time);
    for (std::size_t i = 0; i < frame.node.size(); ++i)
      ASSERT_NEAR(frame.displacement[i], strain * frame.node[i], 1e-9) << frame.time << " s";
    for (const double stress : frame.stress) ASSERT_NEAR(stress, 0.0, 2e3) << frame.time << " s";
  }
}

class FreeContraction : public ::testing::TestWithParam<mesh::ElementKind> {};

TEST_P(FreeContraction, EqualsTheClosedFormThroughTheRun) {
  expect_free_contraction(small_quarter_slab(GetParam()));  // its wide face stands oblique
}

TEST_P(FreeContraction, EqualsItWithARoundedCorner) {
  expect_free_contraction(small_rounded_slab(GetParam()));
}

TEST(FreeContractionOnTwoMeshes, EqualsTheClosedForm) {
  Case c = small_quarter_slab();
  c.section.heat_cells = {.per_column = 3, .per_layer = 2};
  expect_free_contraction(c);
}

INSTANTIATE_TEST_SUITE_P(Elements, FreeContraction,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1,
                                           mesh::ElementKind::q1_bending));

}  // namespace
}  // namespace dccast::casting
