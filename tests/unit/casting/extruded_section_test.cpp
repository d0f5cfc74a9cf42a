// A section one metre thick between two symmetry planes is a section in plane strain.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "core/mesh/slab_mesh.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::Recorder;
using testing::small_casting;

/// A section of quadrilaterals as one layer of hexahedra, in Gmsh's format 2.2.
class ExtrudedSection {
public:
  explicit ExtrudedSection(const mesh::Mesh2D& plane) : plane_(plane) {}

  /// @param without  a group whose facets are in the group free instead; empty: none
  void write(const std::filesystem::path& path, const std::string& without = "") {
    elements_.clear();
    add_walls(without);
    add_slab(without);
    std::ofstream file(path);
    file.precision(17);
    file << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n8\n";
    for (std::size_t i = 0; i < groups.size(); ++i)
      file << (i == 6 ? 3 : 2) << ' ' << i + 1 << " \"" << groups[i] << "\"\n";
    file << "$EndPhysicalNames\n$Nodes\n" << 2 * plane_.nodes() << "\n";
    for (const int layer : {0, 1}) {
      for (int n = 0; n < plane_.nodes(); ++n)
        file << (layer == 0 ? front(n) : back(n)) << ' ' << plane_.point(n)[0] << ' ' << layer
             << ' ' << plane_.point(n)[1] << "\n";
    }
    file << "$EndNodes\n$Elements\n" << elements_.size() << "\n";
    for (std::size_t i = 0; i < elements_.size(); ++i) file << i + 1 << elements_[i] << "\n";
    file << "$EndElements\n";
  }

private:
  int front(int n) const { return n + 1; }
  int back(int n) const { return n + 1 + plane_.nodes(); }
  void element(int shape, int group, const std::vector<int>& nodes) {
    const std::string tag = std::to_string(group + 1);
    std::string line = ' ' + std::to_string(shape) + " 2 " + tag + ' ' + tag;
    for (const int n : nodes) line += ' ' + std::to_string(n);
    elements_.push_back(line);
  }
  void add_walls(const std::string& without) {
    for (const auto& [kind, group] : {std::pair{mesh::PatchKind::symmetry, 0},
                                      {mesh::PatchKind::side, 1},
                                      {mesh::PatchKind::bottom, 2},
                                      {mesh::PatchKind::top, 3}}) {
      const int written = without == groups[std::size_t(group)] ? free_group : group;
      for (const auto& edge : plane_.facets(kind)) {
        const int a = edge.node[0], b = edge.node[1];
        element(3, written, {front(a), front(b), back(b), back(a)});
      }
    }
  }
  void add_slab(const std::string& without) {
    for (int e = 0; e < plane_.elements(); ++e) {
      const int* n = plane_.nodes_of(e);
      element(3, without == "symmetry_y" ? free_group : 4,
              {front(n[0]), front(n[1]), front(n[2]), front(n[3])});
      element(3, 5, {back(n[0]), back(n[1]), back(n[2]), back(n[3])});
      element(5, 6,
              {front(n[0]), front(n[1]), front(n[2]), front(n[3]), back(n[0]), back(n[1]),
               back(n[2]), back(n[3])});
    }
  }

  static constexpr std::array<const char*, 8> groups{
      "symmetry_x", "side_x", "bottom", "top", "symmetry_y", "symmetry_back", "slab", "free"};
  static constexpr int free_group = 7;
  const mesh::Mesh2D& plane_;
  std::vector<std::string> elements_;
};

std::vector<results::StepReport> reports_of(const Case& c) {
  const TemporaryFolder folder;
  Recorder recorder;
  const CheckedCase checked = check(c);
  EXPECT_TRUE(checked.faults.empty()) << testing::all(checked.faults);
  const RunOutcome outcome = run(c, {folder / "", false}, recorder);
  EXPECT_EQ(outcome.end, RunEnd::succeeded) << in_words(outcome.failures);
  return recorder.reports;
}

class Extruded : public ::testing::TestWithParam<mesh::ElementKind> {};

TEST_P(Extruded, GivesWhatTheSectionGives) {
  const TemporaryFolder folder;
  Case section = small_casting(GetParam());
  section.section.growth = false;
  section.cooling.top = thermal::Top::insulated;
  section.time.end = 2.0;
  section.mechanics.options.tolerance = 1e-10;
  section.monitors = {{"corner", 0.28, 0.0}, {"edge", 0.28, 0.05}, {"centre", 0.0, 0.03}};
  const mesh::SlabMesh2D plane(section.section);
  ExtrudedSection(plane.mesh()).write(folder / "extruded.msh");
  Case solid = section;
  solid.section.kind = mesh::SectionKind::quarter_slab;
  solid.section.half_thickness = Curve(1.0);
  solid.section.file = folder / "extruded.msh";
  for (Monitor& monitor : solid.monitors) monitor = {monitor.name, monitor.x, 0.3, monitor.y};
  const auto two = reports_of(section), three = reports_of(solid);
  ASSERT_EQ(two.size(), three.size());

  for (std::size_t i = 0; i < two.size(); ++i) {
    SCOPED_TRACE("t = " + std::to_string(two[i].time));
    EXPECT_NEAR(three[i].wall_heat_flux, two[i].wall_heat_flux, 1e-8 * two[i].wall_heat_flux);
    EXPECT_NEAR(three[i].weight, two[i].weight, 1e-9 * two[i].weight);
    EXPECT_NEAR(three[i].contact_area, two[i].contact_length, 1e-9);
    for (std::size_t m = 0; m < two[i].monitor_displacement.size(); ++m) {
      EXPECT_NEAR(three[i].monitor_temperature[m], two[i].monitor_temperature[m], 1e-7);
      const auto &u = two[i].monitor_displacement[m], &v = three[i].monitor_displacement[m];
      EXPECT_NEAR(v[0], u[0], 1e-9);
      EXPECT_NEAR(v[1], 0.0, 1e-12);
      EXPECT_NEAR(v[2], u[1], 1e-9);
    }
  }
  EXPECT_GT(std::abs(two.back().monitor_displacement[0][0]), 1e-5) << "it has moved";
}

/// Patches that a case needs must have a name in the file.
TEST(ImportedSolid, NeedsBothPlanesOfSymmetryAndASide) {
  const TemporaryFolder folder;
  Case c = small_casting(mesh::ElementKind::q1);
  c.section.growth = false;
  const mesh::SlabMesh2D plane(c.section);
  ExtrudedSection extruded(plane.mesh());
  c.section.kind = mesh::SectionKind::quarter_slab;
  c.section.half_thickness = Curve(1.0);
  c.section.file = folder / "extruded.msh";
  c.monitors.clear();
  for (const auto& [group, remedy] : {std::pair{"symmetry_x", "Physical Surface(\"symmetry_x\")"},
                                      {"symmetry_y", "Physical Surface(\"symmetry_y\")"},
                                      {"side_x", "Physical Surface(\"side_x\")"},
                                      {"top", "Physical Surface(\"top\")"}}) {
    extruded.write(c.section.file, group);
    const CheckedCase checked = check(c);
    ASSERT_EQ(checked.faults.list().size(), 1u) << group << "\n" << testing::all(checked.faults);
    EXPECT_EQ(checked.faults.list()[0].field, "mesh.file");
    EXPECT_NE(checked.faults.list()[0].remedy.find(remedy), std::string::npos)
        << checked.faults.list()[0].remedy;
  }
}

INSTANTIATE_TEST_SUITE_P(Elements, Extruded,
                         ::testing::Values(mesh::ElementKind::q1, mesh::ElementKind::q1_bending));

}  // namespace
}  // namespace dccast::casting
