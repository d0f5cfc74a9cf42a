#include <gtest/gtest.h>

#include <cstdio>
#include <utility>
#include <vector>

#include "core/mesh/slab_mesh.hpp"
#include "core/results/hdf5_file.hpp"
#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::Recorder;
using testing::small_casting;

/// A built-in mesh as Gmsh 2.2 would have written it.
/// @param free_facets  further facets of the boundary, in the group free
void write_gmsh(const mesh::Mesh2D& mesh, const std::filesystem::path& path,
                const std::vector<mesh::Facet<2>>& free_facets = {}) {
  std::ofstream file(path);
  file.precision(17);
  file << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n6\n1 6 \"free\"\n1 1 "
          "\"symmetry\"\n1 2 "
          "\"bottom\"\n"
          "1 3 \"side\"\n1 4 \"top\"\n2 5 \"slab\"\n$EndPhysicalNames\n$Nodes\n"
       << mesh.nodes() << "\n";
  for (int n = 0; n < mesh.nodes(); ++n) {
    file << n + 1 << " " << mesh.point(n)[0] << " " << mesh.point(n)[1] << " 0\n";
  }
  std::size_t elements = std::size_t(mesh.elements()) + free_facets.size();
  for (const auto& patch : mesh.patches) elements += patch.facets.size();
  file << "$EndNodes\n$Elements\n" << elements << "\n";
  int tag = 0;
  for (std::size_t p = 0; p < mesh::patch_kinds; ++p) {
    for (const auto& facet : std::as_const(mesh).facets(mesh::PatchKind(p))) {
      file << ++tag << " 1 2 " << p + 1 << " 1 " << facet.node[0] + 1 << " " << facet.node[1] + 1
           << "\n";
    }
  }
  for (const auto& facet : free_facets)
    file << ++tag << " 1 2 6 1 " << facet.node[0] + 1 << " " << facet.node[1] + 1 << "\n";
  for (int e = 0; e < mesh.elements(); ++e) {
    file << ++tag << (mesh.nodes_per_element == 3 ? " 2" : " 3") << " 2 5 1";
    for (int i = 0; i < mesh.nodes_per_element; ++i) file << " " << mesh.nodes_of(e)[i] + 1;
    file << "\n";
  }
  file << "$EndElements\n";
}

/// Temperatures at three instants, colder towards the side and with time.
void write_temperature(const mesh::Mesh2D& mesh, const std::filesystem::path& path,
                       double warmest) {
  const std::vector<double> time{0.0, 10.0, 20.0};
  std::vector<double> temperature;
  for (double t : time) {
    for (int n = 0; n < mesh.nodes(); ++n) {
      const double x = mesh.point(n)[0], y = mesh.point(n)[1];
      temperature.push_back(warmest - 5.0 * t * (1.0 + 4.0 * x * x) - 300.0 * t * (0.1 - y));
    }
  }
  auto file = results::hdf5::File::create(path);
  file.write("/time_s", time, "s", "time");
  file.write("/temperature_c", {time.size(), std::size_t(mesh.nodes())}, temperature, "degC",
             "temperature");
  file.close();
}

class Prescribed : public ::testing::TestWithParam<mesh::ElementKind> {
protected:
  /// A block that cools by the file, on the mesh of the small casting read from a file.
  Case block(double warmest) {
    Case c = small_casting(GetParam());
    const mesh::Mesh2D mesh = mesh::SlabMesh2D(c.section).mesh();
    write_gmsh(mesh, folder_ / "slab.msh");
    write_temperature(mesh, folder_ / "t.h5", warmest);
    c.section.file = folder_ / "slab.msh";
    c.section.growth = false;
    c.thermal.file = folder_ / "t.h5";
    c.schedule.hold = 0.0;
    c.time.step = Curve(1.0);
    c.monitors = {{"corner", 0.28, 0.0}, {"top of the side", 0.28, 0.1}};
    return c;
  }

  std::vector<results::StepReport> reports_of(const Case& c) {
    const auto checked = check(c);
    EXPECT_TRUE(checked.faults.empty())
        << checked.faults.list()[0].field << ": " << checked.faults.list()[0].message;
    Recorder recorder;
    std::filesystem::create_directories(folder_ / "run");
    const auto outcome = run(c, {folder_ / "run", false}, recorder);
    EXPECT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
    EXPECT_EQ(recorder.reports.size(), 20u);
    for (const auto& r : recorder.reports) {
      EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-4 * r.weight) << "t = " << r.time;
      EXPECT_EQ(r.nodes, recorder.reports.front().nodes) << "it does not grow";
    }
    return recorder.reports;
  }

  const TemporaryFolder folder_;
};

TEST_P(Prescribed, TemperaturesAreThoseOfTheFile) {
  const Case c = block(660.0);
  reports_of(c);
  const results::ResultReader reader(folder_ / "run/results.h5");
  const auto frame = reader.frame(reader.frames() - 1);
  for (std::int64_t n = 0; n < frame.nodes(); ++n) {
    const double x = frame.node[2 * std::size_t(n)], y = frame.node[2 * std::size_t(n) + 1];
    EXPECT_NEAR(frame.temperature[std::size_t(n)],
                660.0 - 100.0 * (1.0 + 4.0 * x * x) - 6000.0 * (0.1 - y), 1e-9);
  }
}

TEST_P(Prescribed, RunsWithLiquidAndConfinement) {
  const auto reports = reports_of(block(660.0));
  EXPECT_LT(reports.back().monitor_displacement[0][0], -1e-4);
}

TEST_P(Prescribed, RunsWithoutLiquid) {
  Case c = block(640.0);
  c.mechanics.options.liquid = mechanics::Liquid::solid;
  const auto reports = reports_of(c);
  EXPECT_LT(reports.back().monitor_displacement[0][0], -1e-4);
}

TEST_P(Prescribed, RunsWithoutConfinement) {
  Case c = block(640.0);
  c.mechanics.options.liquid = mechanics::Liquid::solid;
  const auto held = reports_of(c);
  c.mechanics.options.confinement = false;
  const auto free = reports_of(c);
  // The block contracts: hot metal leaves the mould as if there were none, and never passes it.
  EXPECT_LT(free.front().monitor_displacement[1][0], -1e-6);
  for (std::size_t i = 0; i < held.size(); ++i) {
    EXPECT_LE(held[i].monitor_displacement[1][0], 1e-12);
    EXPECT_NEAR(held[i].monitor_displacement[1][0], free[i].monitor_displacement[1][0], 1e-6);
  }
}

TEST_P(Prescribed, RunsWithoutContact) {
  Case c = block(640.0);
  c.mechanics.options.liquid = mechanics::Liquid::solid;
  c.mechanics.options.confinement = false;
  c.mechanics.options.contact = false;
  for (const auto& r : reports_of(c)) EXPECT_EQ(r.monitor_displacement[0][1], 0.0);
}

/// With the file's temperature on the built-in mesh the answer is the same as on the imported one.
TEST_P(Prescribed, AnImportedMeshIsNoOtherThanTheBuiltIn) {
  Case c = block(660.0);
  const auto imported = reports_of(c);
  c.section.file.clear();
  const auto built_in = reports_of(c);
  for (std::size_t i = 0; i < imported.size(); ++i) {
    EXPECT_NEAR(imported[i].monitor_displacement[0][0], built_in[i].monitor_displacement[0][0],
                1e-8);
    EXPECT_NEAR(imported[i].monitor_displacement[0][1], built_in[i].monitor_displacement[0][1],
                1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(Elements, Prescribed,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1));

class ImportedMesh : public ::testing::Test {
protected:
  const TemporaryFolder folder_;
  Case casting_ = [this] {
    Case c = small_casting(mesh::ElementKind::q1);
    c.section.file = folder_ / "slab.msh";
    c.section.growth = false;
    c.monitors.pop_back();  // the one that waits for its metal
    return c;
  }();
  mesh::Mesh2D mesh_ = mesh::SlabMesh2D(small_casting(mesh::ElementKind::q1).section).mesh();

  CheckedCase checked() {
    write_gmsh(mesh_, casting_.section.file, free_);
    return check(casting_);
  }
  std::vector<Fault> faults() { return checked().faults.list(); }

  /// Leaves a patch free on purpose.
  void set_free(mesh::PatchKind patch) {
    auto& facets = mesh_.facets(patch);
    free_.insert(free_.end(), facets.begin(), facets.end());
    facets.clear();
  }

  std::vector<mesh::Facet<2>> free_;  ///< of the boundary
};

TEST_F(ImportedMesh, ThatFitsTheCaseIsSound) {
  EXPECT_TRUE(faults().empty());
  EXPECT_TRUE(checked().warnings.empty());
}

/// Found by a user: a width of 280 m instead of mm gave a curl of zero without a message.
TEST_F(ImportedMesh, InMillimetresIsRefusedWithTheFactor) {
  for (double& coordinate : mesh_.node) coordinate *= 1000.0;
  casting_.monitors.clear();
  const auto found = faults();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].field, "mesh.file");
  EXPECT_EQ(found[0].message, "is 280 m wide");
  EXPECT_NE(found[0].permitted.find("0.28 m"), std::string::npos);
  EXPECT_NE(found[0].remedy.find("millimetres"), std::string::npos);
  EXPECT_NE(found[0].remedy.find("0.001"), std::string::npos);
}

TEST_F(ImportedMesh, OfAnotherWidthIsRefused) {
  for (std::size_t i = 0; i < mesh_.node.size(); i += 2) mesh_.node[i] *= 1.02;
  ASSERT_EQ(faults().size(), 1u);
  EXPECT_NE(faults()[0].remedy.find("section.half_width"), std::string::npos);
  for (std::size_t i = 0; i < mesh_.node.size(); i += 2) mesh_.node[i] *= 0.985;  // 0.5 % over
  EXPECT_TRUE(faults().empty());
}

TEST_F(ImportedMesh, OfAnotherHeightIsWarnedOf) {
  casting_.section.initial_depth = 0.2;
  EXPECT_TRUE(faults().empty());
  EXPECT_EQ(checked().warnings.list().size(), 1u);
}

TEST_F(ImportedMesh, WantsEveryGroupThatTheCaseNeeds) {
  for (const auto& [patch, name] :
       {std::pair{mesh::PatchKind::side, "'side'"}, std::pair{mesh::PatchKind::top, "'top'"},
        std::pair{mesh::PatchKind::symmetry, "'symmetry'"},
        std::pair{mesh::PatchKind::bottom, "bottom"}}) {
    const auto whole = mesh_;
    set_free(patch);
    const auto found = faults();
    ASSERT_EQ(found.size(), 1u) << name;
    EXPECT_EQ(found[0].field, "mesh.file");
    EXPECT_NE((found[0].message + found[0].permitted).find(name), std::string::npos)
        << found[0].message;
    EXPECT_FALSE(found[0].remedy.empty());
    mesh_ = whole;
    free_.clear();
  }
}

TEST_F(ImportedMesh, WantsAGroupForEachOuterSide) {
  mesh_.facets(mesh::PatchKind::side).pop_back();
  const auto found = faults();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].message.find("has 1 outer side of cells without a group"), 0u)
      << found[0].message;
}

TEST_F(ImportedMesh, WantsNoGroupThatTheCaseDoesWithout) {
  set_free(mesh::PatchKind::top);
  casting_.cooling.top = thermal::Top::insulated;
  EXPECT_TRUE(faults().empty());
  set_free(mesh::PatchKind::symmetry);
  casting_.mechanics.enabled = false;
  EXPECT_TRUE(faults().empty());
}

TEST(ImportedBillet, LiesOnOneSideOfItsAxis) {
  const TemporaryFolder folder;
  Case c = small_casting(mesh::ElementKind::q1);
  mesh::Mesh2D mesh = mesh::SlabMesh2D(c.section).mesh();
  c.section.kind = mesh::SectionKind::axisymmetric;
  c.section.file = folder / "billet.msh";
  c.section.growth = false;
  c.monitors = {{"rim", 0.26, 0.0}};
  write_gmsh(mesh, c.section.file);
  EXPECT_TRUE(check(c).faults.empty());

  for (std::size_t i = 0; i < mesh.node.size(); i += 2) mesh.node[i] -= 0.01;
  write_gmsh(mesh, c.section.file);
  const CheckedCase beyond = check(c);
  ASSERT_EQ(beyond.faults.list().size(), 1u);
  EXPECT_EQ(beyond.faults.list().front().field, "mesh.file");
}

}  // namespace
}  // namespace dccast::casting
