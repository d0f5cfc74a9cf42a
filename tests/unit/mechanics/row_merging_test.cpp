// State of points where rows of hexahedra are merged.
#include "core/mechanics/rows_of_points.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/mechanics/slab_mechanics.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "tests/unit/mechanics/slab_bench.hpp"

namespace dccast::mechanics {
namespace {

using Tensor = SymmetricTensor<3>;
constexpr double gauss = 0.57735026918962576451;

/// Rows of one cell: 10, 20, 30 and 10 mm high. The two in the middle are merged.
mesh::MergedRows middle_pair() {
  return {{0.0, 0.01, 0.03, 0.06, 0.07}, {2}, 4, 1};
}

/// Height of a point of a cell [m]; the first four are the lower ones.
double height_of(std::size_t q, double from, double to) {
  return 0.5 * (from + to) + (q < 4 ? -0.5 : 0.5) * gauss * (to - from);
}

std::vector<Tensor> field_of(const mesh::MergedRows& rows, const auto& value) {
  std::vector<Tensor> field;
  for (std::size_t row = 0; row + 1 < rows.height.size(); ++row) {
    for (std::size_t q = 0; q < 8; ++q) {
      Tensor t;
      for (std::size_t c = 0; c < Tensor::components; ++c)
        t[c] = value(c, q, height_of(q, rows.height[row], rows.height[row + 1]));
      field.push_back(t);
    }
  }
  return field;
}

TEST(RowsOfPoints, ALinearFieldStaysWhatItIs) {
  const auto value = [](std::size_t c, std::size_t q, double z) {
    return 1.0 + double(c) + 0.3 * double(q % 4) + (2.0 - double(q % 4)) * z;
  };
  const mesh::MergedRows merged = middle_pair();
  const auto after = RowsOfPoints<3>(merged).projected(field_of(merged, value));
  const double rows[] = {0.0, 0.01, 0.06, 0.07};
  ASSERT_EQ(after.size(), 24u);
  for (std::size_t i = 0; i < after.size(); ++i) {
    const std::size_t row = i / 8, q = i % 8;
    for (std::size_t c = 0; c < Tensor::components; ++c)
      EXPECT_NEAR(after[i][c], value(c, q, height_of(q, rows[row], rows[row + 1])), 1e-13);
  }
}

TEST(RowsOfPoints, AnyFieldKeepsItsMeanAndFirstMoment) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const mesh::MergedRows merged = middle_pair();
  const auto before =
      field_of(merged, [&](std::size_t, std::size_t, double) { return any(random); });
  const auto after = RowsOfPoints<3>(merged).projected(before);
  for (std::size_t q = 0; q < 4; ++q) {
    double mean = 0.0, moment = 0.0;
    for (const std::size_t end : {q, q + 4}) {
      mean += 0.5 * 0.02 * before[8 + end][0] + 0.5 * 0.03 * before[16 + end][0];
      moment += 0.5 * 0.02 * before[8 + end][0] * height_of(end, 0.01, 0.03) +
                0.5 * 0.03 * before[16 + end][0] * height_of(end, 0.03, 0.06);
      mean -= 0.5 * 0.05 * after[8 + end][0];
      moment -= 0.5 * 0.05 * after[8 + end][0] * height_of(end, 0.01, 0.06);
    }
    EXPECT_NEAR(mean, 0.0, 1e-15);
    EXPECT_NEAR(moment, 0.0, 1e-16);
  }
}

TEST(RowsOfPoints, ForcesDoTheSameWorkOnWhatTheMergedMeshCanDo) {
  const mesh::MergedRows merged = middle_pair();
  const auto displacement = [](double z) { return z < 0.01 ? z : z > 0.06 ? 1.0 - z : 0.4 * z; };
  std::vector<double> force;
  for (std::size_t i = 0; i < 5 * 4 * 3; ++i) force.push_back(std::sin(double(i * i)));
  double before = 0.0;
  for (std::size_t i = 0; i < force.size(); ++i)
    before += force[i] * displacement(merged.height[i / 12]);
  const auto restricted = RowsOfPoints<3>(merged).restricted(force);
  const double rows[] = {0.0, 0.01, 0.06, 0.07};
  double after = 0.0;
  for (std::size_t i = 0; i < restricted.size(); ++i)
    after += restricted[i] * displacement(rows[i / 12]);
  EXPECT_NEAR(after, before, 1e-14);
}

TEST(RowsOfPoints, APairIsSolidWhereBothAre) {
  mesh::MergedRows merged = middle_pair();
  merged.elements_per_row = 2;
  const std::vector<char> solid{1, 0, 1, 1, 1, 0, 0, 0};
  EXPECT_EQ(RowsOfPoints<3>(merged).all_of(solid), (std::vector<char>{1, 0, 1, 0, 0, 0}));
}

using namespace testing;

/// Merges the two lower of the three rows of a slab.
template <class Element>
MergeChecks merge_lower_rows(SlabBench<Element>& bench, const auto& temperature) {
  const mesh::MergedRows merged{bench.slab.row_heights(),
                                {1},
                                std::size_t(bench.slab.nodes_per_row()),
                                std::size_t(bench.slab.elements_per_row())};
  auto projected =
      bench.mechanics.projected(bench.state, merged, bench.element_temperature(temperature));
  bench.slab.merge(merged);
  return bench.mechanics.follow_merging(bench.state, std::move(projected), bench.slab.mesh(),
                                        bench.element_temperature(temperature));
}

template <class Element>
class MergedSlab : public ::testing::Test {};
using Hexahedra = ::testing::Types<fem::Q1Hexahedron, fem::BendingHexahedron>;
TYPED_TEST_SUITE(MergedSlab, Hexahedra);

/// Even contraction is a state that the merged mesh can have: nothing is to change.
TYPED_TEST(MergedSlab, AnEvenStateStaysWhatItIs) {
  Options options = tight(1e-9);
  options.confinement = false;
  options.gravity = 1e-6;
  SlabBench<TypeParam> bench(options);
  const auto cold = uniform(300.0);
  bench.start(uniform(600.0));
  bench.step(cold);
  const double before = bench.moved(bench.slab.mesh().nodes() - 1)[2];
  const MergeChecks checks = merge_lower_rows(bench, cold);

  EXPECT_LE(checks.mass_error, 1e-14);
  EXPECT_EQ(bench.slab.mesh().elements(), int(bench.state.solid.size()));

  bench.step(cold, 1e-3);
  EXPECT_NEAR(bench.moved(bench.slab.mesh().nodes() - 1)[2], before, 1e-6 * std::abs(before));
}

/// A slab that has curled stays as it is but for what the coarser mesh cannot have: the next
/// moment moves its corner by little.
TYPED_TEST(MergedSlab, ACurledSlabKeepsItsCurl) {
  SlabBench<TypeParam> bench(tight(1e-9));
  const auto cooled = by_height([](double z) { return 420.0 + 1500.0 * z; });
  bench.start(uniform(600.0));
  bench.step(cooled);
  int corner = 0;
  for (int n = 0; n < bench.slab.nodes_per_row(); ++n)
    if (bench.moved(n)[2] > bench.moved(corner)[2]) corner = n;
  const double curl = bench.moved(corner)[2];
  const MergeChecks checks = merge_lower_rows(bench, cooled);

  EXPECT_LE(checks.mass_error, 1e-4);
  EXPECT_LE(bench.moved(corner)[2], curl) << "nodes that stay keep their displacement";

  bench.step(cooled, 1e-3);
  EXPECT_NEAR(bench.moved(corner)[2], curl, 0.03 * curl);
  EXPECT_GT(curl, 1e-4);
}

TEST(MergedTetrahedra, AreRefused) {
  SlabBench<fem::P1Tetrahedron> bench(tight(1e-9));
  const auto even = uniform(600.0);
  bench.start(even);
  EXPECT_THROW(merge_lower_rows(bench, even), std::logic_error);
}

}  // namespace
}  // namespace dccast::mechanics
