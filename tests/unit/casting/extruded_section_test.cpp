// A section one metre thick between two symmetry planes is a section in plane strain.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "core/mesh/slab_mesh.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::Recorder;
using testing::small_casting;
using testing::TemporaryFolder;

/// A section of quadrilaterals as one layer of hexahedra, in Gmsh's format 2.2.
class ExtrudedSection {
public:
  explicit ExtrudedSection(const mesh::Mesh2D& plane) : plane_(plane) {
    int next_group = 1;
    for (const char* name :
         {"symmetry_x", "side_x", "bottom", "top", "symmetry_y", "symmetry_back"})
      names_ << "2 " << next_group++ << " \"" << name << "\"\n";
    names_ << "3 7 \"slab\"\n";
    for (const auto& [kind, group] : {std::pair{mesh::PatchKind::symmetry, 1},
                                      {mesh::PatchKind::side, 2},
                                      {mesh::PatchKind::bottom, 3},
                                      {mesh::PatchKind::top, 4}}) {
      for (const auto& edge : plane.facets(kind)) {
        const int a = edge.node[0], b = edge.node[1];
        element(3, group, {front(a), front(b), back(b), back(a)});
      }
    }
    for (int e = 0; e < plane.elements(); ++e) {
      const int* n = plane.nodes_of(e);
      element(3, 5, {front(n[0]), front(n[1]), front(n[2]), front(n[3])});
      element(3, 6, {back(n[0]), back(n[1]), back(n[2]), back(n[3])});
      element(5, 7,
              {front(n[0]), front(n[1]), front(n[2]), front(n[3]), back(n[0]), back(n[1]),
               back(n[2]), back(n[3])});
    }
  }

  void write(const std::filesystem::path& path) const {
    std::ofstream file(path);
    file.precision(17);
    file << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n7\n"
         << names_.str() << "$EndPhysicalNames\n$Nodes\n"
         << 2 * plane_.nodes() << "\n";
    for (const int layer : {0, 1}) {
      for (int n = 0; n < plane_.nodes(); ++n)
        file << (layer == 0 ? front(n) : back(n)) << ' ' << plane_.point(n)[0] << ' ' << layer
             << ' ' << plane_.point(n)[1] << "\n";
    }
    file << "$EndNodes\n$Elements\n" << count_ << "\n" << elements_.str() << "$EndElements\n";
  }

private:
  int front(int n) const { return n + 1; }
  int back(int n) const { return n + 1 + plane_.nodes(); }
  void element(int shape, int group, const std::vector<int>& nodes) {
    elements_ << ++count_ << ' ' << shape << " 2 " << group << ' ' << group;
    for (const int n : nodes) elements_ << ' ' << n;
    elements_ << "\n";
  }

  const mesh::Mesh2D& plane_;
  std::ostringstream names_, elements_;
  int count_ = 0;
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

INSTANTIATE_TEST_SUITE_P(Elements, Extruded,
                         ::testing::Values(mesh::ElementKind::q1, mesh::ElementKind::q1_bending));

}  // namespace
}  // namespace dccast::casting
