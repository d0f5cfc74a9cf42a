#include "core/mesh/gmsh_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace dccast::mesh {
namespace {

using testing::HasSubstr;

const std::string head_2 = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const std::string head_4 = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
const std::string names =
    "$PhysicalNames\n5\n1 1 \"symmetry\"\n1 2 \"bottom\"\n1 3 \"side\"\n1 4 \"top\"\n"
    "2 7 \"slab\"\n$EndPhysicalNames\n";
// A strip of two squares with the tags 11 12 13 below and 21 22 23 above.
const std::string nodes_2 =
    "$Nodes\n6\n11 0 0 0\n12 1 0 0\n13 2 0 0\n21 0 1 0\n22 1 1 0\n23 2 1 0\n$EndNodes\n";
const std::string boundary_2 =
    "1 1 2 1 1 11 21\n2 1 2 2 2 13 12\n3 1 2 2 2 11 12\n4 1 2 3 3 13 23\n5 1 2 4 4 23 22\n"
    "6 1 2 4 4 22 21\n";
// The second triangle is given clockwise.
const std::string triangles_2 =
    "7 2 2 7 1 11 12 22\n8 2 2 7 1 11 21 22\n9 2 2 7 1 12 13 23\n10 2 2 7 1 12 23 22\n";
const std::string quadrilaterals_2 = "7 3 2 7 1 11 12 22 21\n8 3 2 7 1 12 22 23 13\n";

std::string elements_2(int count, const std::string& lines) {
  return "$Elements\n" + std::to_string(count) + "\n" + lines + "$EndElements\n";
}

const std::string triangle_file =
    head_2 + names + nodes_2 + elements_2(10, boundary_2 + triangles_2);
const std::string quadrilateral_file =
    head_2 + names + nodes_2 + elements_2(8, boundary_2 + quadrilaterals_2);

/// The same triangles in the format of Gmsh 4, with a point, parametric nodes and an unknown
/// section.
const std::string triangle_file_4 =
    head_4 + names +
    "$Entities\n1 4 1 0\n5 0 0 0 0\n"
    "1 0 0 0 0 1 0 1 1 2 5 -6\n2 0 0 0 2 0 0 1 2 2 5 6\n3 2 0 0 2 1 0 1 3 0\n4 0 1 0 2 1 0 1 4 0\n"
    "1 0 0 0 2 1 0 1 7 4 1 2 3 4\n$EndEntities\n"
    "$Comments\nmade \"by hand\"\n$EndComments\n"
    "$Nodes\n3 6 11 23\n0 5 0 1\n11\n0 0 0\n1 2 1 2\n12\n13\n1 0 0 0.5\n2 0 0 1\n"
    "2 1 0 3\n21\n22\n23\n0 1 0\n1 1 0\n2 1 0\n$EndNodes\n"
    "$Elements\n6 11 1 11\n0 5 15 1\n1 11\n1 1 1 1\n2 11 21\n1 2 1 2\n3 13 12\n4 11 12\n"
    "1 3 1 1\n5 13 23\n1 4 1 2\n6 23 22\n7 22 21\n"
    "2 1 2 4\n8 11 12 22\n9 11 21 22\n10 12 13 23\n11 12 23 22\n$EndElements\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto begin = text.find(from);
  EXPECT_NE(begin, std::string::npos) << from;
  return text.replace(begin, from.size(), to);
}

Mesh2D mesh_of(const std::string& text, ElementKind kind = ElementKind::p1) {
  Faults faults;
  auto mesh = parse_gmsh<2>(text, "slab.msh", kind, faults);
  EXPECT_TRUE(mesh) << (faults.empty() ? "" : faults.list()[0].message);
  return mesh.value_or(Mesh2D{});
}

/// The message of the first fault; "" when the file was accepted.
std::string fault_of(const std::string& text, ElementKind kind = ElementKind::p1) {
  Faults faults;
  if (parse_gmsh<2>(text, "slab.msh", kind, faults)) return "";
  if (faults.empty()) return "refused without a fault";
  EXPECT_EQ(faults.list()[0].field, "mesh.file");
  EXPECT_EQ(faults.list()[0].value, "slab.msh");
  return faults.list()[0].message;
}

double doubled_area(const Mesh2D& mesh, int element) {
  double sum = 0.0;
  const int* nodes = mesh.nodes_of(element);
  for (int i = 0; i < mesh.nodes_per_element; ++i) {
    const double* a = mesh.point(nodes[i]);
    const double* b = mesh.point(nodes[(i + 1) % mesh.nodes_per_element]);
    sum += a[0] * b[1] - a[1] * b[0];
  }
  return sum;
}

void expect_the_strip(const Mesh2D& mesh, int elements) {
  EXPECT_EQ(mesh.nodes(), 6);
  EXPECT_EQ(mesh.node, (std::vector<double>{0, 0, 1, 0, 2, 0, 0, 1, 1, 1, 2, 1}));

  ASSERT_EQ(mesh.elements(), elements);
  for (int e = 0; e < elements; ++e) EXPECT_EQ(doubled_area(mesh, e), 4.0 / elements);

  EXPECT_EQ(patch_nodes(mesh, PatchKind::bottom), (std::vector{0, 1, 2}));
  EXPECT_EQ(patch_nodes(mesh, PatchKind::side), (std::vector{2, 5}));
  EXPECT_EQ(patch_nodes(mesh, PatchKind::symmetry), (std::vector{3, 0}));
  EXPECT_EQ(mesh.facets(PatchKind::top).size(), 2u);
}

/// Every facet is an edge of its element, in the direction in which the domain lies to its left.
void expect_facets_of_their_elements(const Mesh2D& mesh) {
  for (const auto& patch : mesh.patches) {
    for (const auto& facet : patch.facets) {
      const int* nodes = mesh.nodes_of(facet.element);
      int found = 0;
      for (int i = 0; i < mesh.nodes_per_element; ++i)
        found +=
            nodes[i] == facet.node[0] && nodes[(i + 1) % mesh.nodes_per_element] == facet.node[1];
      EXPECT_EQ(found, 1);
    }
  }
}

TEST(GmshReader, ReadsTrianglesOfFormat2) {
  const Mesh2D mesh = mesh_of(triangle_file);
  expect_the_strip(mesh, 4);
  expect_facets_of_their_elements(mesh);
}

TEST(GmshReader, ReadsTrianglesOfFormat4) {
  const Mesh2D mesh = mesh_of(triangle_file_4);
  expect_the_strip(mesh, 4);
  expect_facets_of_their_elements(mesh);
}

TEST(GmshReader, ReadsQuadrilateralsAndTurnsThemRound) {
  const Mesh2D mesh = mesh_of(quadrilateral_file, ElementKind::q1);
  expect_the_strip(mesh, 2);
  expect_facets_of_their_elements(mesh);
}

TEST(GmshReader, ReadsLineEndsOfWindows) {
  std::string text;
  for (const char c : triangle_file) text += c == '\n' ? "\r\n" : std::string(1, c);
  expect_the_strip(mesh_of(text), 4);
}

/// A group with -2 turns its curve round, which changes no mesh.
TEST(GmshReader, TakesReversedEntitiesIntoTheirGroups) {
  std::string text = replaced(triangle_file_4, "1 2 2 5 6", "1 -2 2 5 6");
  text = replaced(text, "2 1 0 1 3 0", "2 1 0 1 -3 0");
  expect_the_strip(mesh_of(replaced(text, "2 1 0 1 7 4", "2 1 0 1 -7 4")), 4);
  expect_the_strip(mesh_of(replaced(triangle_file, "4 1 2 3 3 13 23", "4 1 2 -3 3 23 13")), 4);
}

/// MSH 2.2 repeats a cell for each of its groups, in 2D and 3D.
TEST(GmshReader, CellsMayBeInSeveralGroups) {
  const std::string other =
      "11 2 2 8 1 11 12 22\n12 2 2 8 1 11 21 22\n13 2 2 8 1 12 13 23\n"
      "14 2 2 8 1 12 23 22\n15 2 2 9 1 12 23 22\n";
  const std::string text = head_2 + names + nodes_2;
  expect_the_strip(mesh_of(text + elements_2(15, boundary_2 + triangles_2 + other)), 4);
  EXPECT_THAT(fault_of(text + elements_2(14, boundary_2 + triangles_2 + triangles_2)),
              HasSubstr("overlap"))
      << "twice in one group";

  const std::string quadrilaterals = quadrilaterals_2 + "9 3 2 0 1 11 12 22 21\n";
  expect_the_strip(mesh_of(text + elements_2(9, boundary_2 + quadrilaterals), ElementKind::q1), 2);
  expect_the_strip(mesh_of(replaced(triangle_file_4, "1 7 4 1 2 3 4", "3 7 8 9 4 1 2 3 4")), 4);
}

TEST(GmshReader, TakesARoundedHeightForFlat) {
  for (const char* height : {"-1.7e-17", "1e-9", "-9e-7"})
    expect_the_strip(mesh_of(replaced(triangle_file, "22 1 1 0", fmt::format("22 1 1 {}", height))),
                     4);
  EXPECT_EQ(fault_of(replaced(triangle_file, "22 1 1 0", "22 1 1 1e-5")),
            "has nodes with z other than 0");
}

TEST(GmshReader, ReadsWhatStandsBeforeTheFormatAndNamesWithoutQuotes) {
  const std::string comments = "$Comments\nmade \"by hand\", $5\n$EndComments\n";
  for (const std::string& text : {triangle_file, triangle_file_4}) {
    expect_the_strip(mesh_of("\xEF\xBB\xBF" + text), 4);
    expect_the_strip(mesh_of(comments + text), 4);
    expect_the_strip(mesh_of("\xEF\xBB\xBF\n" + comments + comments + text), 4);
  }

  std::string plain;
  for (const char c : names)
    if (c != '"') plain += c == '\n' ? " \r\n" : std::string(1, c);
  expect_the_strip(mesh_of(replaced(triangle_file, names, plain)), 4);
  EXPECT_EQ(fault_of(replaced(triangle_file, "\"side\"", "long side")),
            "has the unknown physical group 'long side'");
}

/// The strip cut between its squares into two partitions. Its interface has the group of the whole.
TEST(GmshReader, ReadsAPartitionedMesh) {
  const std::string parts =
      "$PartitionedEntities\n2\n1\n1 2\n2 6 2 0\n7 0 5 1 1 0 0 0 0\n8 1 2 2 1 2 1 0 0 0\n"
      "5 1 1 1 1 0 0 0 0 1 0 1 1 2 7 -8\n6 1 2 1 1 0 0 0 1 0 0 1 2 0\n"
      "7 1 2 1 2 1 0 0 2 0 0 1 2 0\n8 1 3 1 2 2 0 0 2 1 0 1 3 0\n"
      "9 1 4 2 1 2 0 1 0 2 1 0 1 4 0\n10 2 1 2 1 2 1 0 0 1 1 0 1 7 0\n"
      "2 2 1 1 1 0 0 0 1 1 0 1 7 0\n3 2 1 1 2 1 0 0 2 1 0 1 7 0\n$EndPartitionedEntities\n";
  const std::string elements =
      "$Elements\n8 12 1 12\n0 7 15 1\n1 11\n1 5 1 1\n2 11 21\n1 6 1 1\n4 11 12\n1 7 1 1\n"
      "3 13 12\n1 8 1 1\n5 13 23\n1 9 1 2\n6 23 22\n7 22 21\n1 10 1 1\n12 12 22\n"
      "2 2 2 2\n8 11 12 22\n9 11 21 22\n$EndElements\n";
  std::string text = replaced(triangle_file_4, "$Comments\n", parts + "$Comments\n");
  text = text.substr(0, text.find("$Elements")) + elements;
  text = replaced(text, "$Elements\n8 12", "$Elements\n9 12");
  text = replaced(text, "$EndElements", "2 3 2 2\n10 12 13 23\n11 12 23 22\n$EndElements");
  expect_the_strip(mesh_of(text), 4);
}

TEST(GmshReader, CellsThatWereNotSavedGetTheRemedy) {
  Faults faults;
  EXPECT_FALSE(parse_gmsh<2>(head_2 + names + nodes_2 + elements_2(6, boundary_2), "slab.msh",
                             ElementKind::q1, faults));
  EXPECT_EQ(faults.list()[0].message, "has no cells");
  EXPECT_THAT(faults.list()[0].remedy, HasSubstr("Physical Surface(\"metal\")"));
}

TEST(GmshReader, TurnsSolidElementsRound) {
  const std::string cube =
      "$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 "
      "1\n$EndNodes\n";
  const std::string group = "$PhysicalNames\n2\n2 1 \"bottom\"\n2 2 \"free\"\n$EndPhysicalNames\n";
  const std::string rest =
      "3 3 2 2 1 5 6 7 8\n4 3 2 2 1 1 2 6 5\n5 3 2 2 1 2 3 7 6\n6 3 2 2 1 3 4 8 7\n"
      "7 3 2 2 1 4 1 5 8\n";

  for (const char* hexahedron : {"1 2 3 4 5 6 7 8", "1 4 3 2 5 8 7 6"}) {
    Faults faults;
    const auto mesh = parse_gmsh<3>(
        head_2 + group + cube +
            elements_2(7, "1 3 2 1 1 1 2 3 4\n" + rest + "2 5 2 9 1 " + hexahedron + "\n"),
        "cube.msh", ElementKind::q1, faults);
    ASSERT_TRUE(mesh) << faults.list()[0].message;
    EXPECT_EQ(mesh->element_node, (std::vector{0, 1, 2, 3, 4, 5, 6, 7}));
    ASSERT_EQ(mesh->facets(PatchKind::bottom).size(), 1u);
    EXPECT_EQ(mesh->facets(PatchKind::bottom)[0].node,
              (std::array{0, 3, 2, 1}));  // normal downwards
  }

  Faults faults;
  const auto tetrahedron =
      parse_gmsh<3>(head_2 + group + "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n" +
                        elements_2(5,
                                   "1 2 2 1 1 1 2 3\n2 4 2 9 1 1 3 2 4\n3 2 2 2 1 1 2 4\n"
                                   "4 2 2 2 1 2 3 4\n5 2 2 2 1 3 1 4\n"),
                    "tetrahedron.msh", ElementKind::p1, faults);
  ASSERT_TRUE(tetrahedron) << faults.list()[0].message;
  EXPECT_EQ(tetrahedron->element_node, (std::vector{0, 1, 2, 3}));
  EXPECT_EQ(tetrahedron->facets(PatchKind::bottom)[0].nodes, 3);
}

TEST(GmshReader, WantsEachOuterSideInAGroup) {
  const std::string text = replaced(triangle_file, "4 1 2 3 3 13 23", "4 1 2 0 3 13 23");
  EXPECT_EQ(fault_of(text),
            "has 1 outer side of cells without a group, at first that between (2, 0) m, (2, 1) m");

  // A boundary that is free on purpose has a group, too, and no patch.
  const Mesh2D mesh = mesh_of(replaced(triangle_file, "\"side\"", "\"free\""));
  EXPECT_EQ(mesh.find("free"), nullptr);
  EXPECT_TRUE(patch_nodes(mesh, PatchKind::side).empty());
  const std::string both = replaced(triangle_file, "\"side\"", "\"free\"");
  EXPECT_EQ(fault_of(replaced(both, "4 1 2 3 3 13 23", "4 1 2 3 3 12 11")),
            "has a facet in two groups, bottom and free");
}

/// The strip in two halves: the nodes 12 and 22 of the right half are doubled as 32 and 42.
std::string halves(const std::string& file, const std::string& place_of_32) {
  std::string text = replaced(file, "$Nodes\n6\n", "$Nodes\n8\n");
  text = replaced(text, "$EndNodes", "32 " + place_of_32 + " 0\n42 1 1 0\n$EndNodes");
  text = replaced(text, "2 1 2 2 2 13 12", "2 1 2 2 2 13 32");
  return replaced(text, "5 1 2 4 4 23 22", "5 1 2 4 4 23 42");
}

TEST(GmshReader, FindsCellsThatTouchWithoutSharingTheirNodes) {
  std::string quadrilaterals =
      replaced(halves(quadrilateral_file, "1 0"), "12 22 23 13", "32 42 23 13");
  EXPECT_EQ(fault_of(quadrilaterals, ElementKind::q1),
            "has cells that touch but are not joined, at 4 nodes, at first at (1, 0) m: nodes 12 "
            "and 32 lie at one place");

  const std::string split = "9 2 2 7 1 32 13 23\n10 2 2 7 1 32 23 42\n";
  const std::string triangles =
      replaced(halves(triangle_file, "1 0"), "9 2 2 7 1 12 13 23\n10 2 2 7 1 12 23 22\n", split);
  EXPECT_THAT(fault_of(triangles), HasSubstr("touch but are not joined"));
  // Also where the doubled nodes differ by the rounding of a file.
  EXPECT_THAT(fault_of(replaced(halves(triangle_file, "1.0000004 -3e-7"),
                                "9 2 2 7 1 12 13 23\n10 2 2 7 1 12 23 22\n", split)),
              HasSubstr("touch but are not joined"));

  // A gap that can be seen is none of these, but the strip lies in pieces.
  std::string apart = replaced(halves(quadrilateral_file, "1.2 0"), "12 22 23 13", "32 42 23 13");
  apart = replaced(apart, "42 1 1 0", "42 1.2 1 0");
  EXPECT_EQ(fault_of(apart, ElementKind::q1),
            "lies in 2 pieces that share no side of a cell; one of them is at (1.2, 0) m");
}

TEST(GmshReader, FindsANodeThatHangsInTheSideOfACell) {
  // A square beside two of half its height.
  const std::string text =
      head_2 + names +
      "$Nodes\n8\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 1 0.5 0\n6 2 0 0\n7 2 0.5 0\n8 2 1 0\n"
      "$EndNodes\n" +
      elements_2(3, "1 3 2 7 1 1 2 3 4\n2 3 2 7 1 2 6 7 5\n3 3 2 7 1 5 7 8 3\n");
  EXPECT_EQ(fault_of(text, ElementKind::q1),
            "has cells that touch but are not joined, at 1 nodes, at first at (1, 0.5) m: node 5 "
            "hangs in the side of a cell");
}

/// A brick between x, y and z. Bricks of one part share their nodes.
struct Brick {
  std::array<double, 2> x, y, z;
  int part = 0;
};

std::string solid_of(const std::vector<Brick>& bricks) {
  std::map<std::tuple<double, double, double, int>, int> number;
  std::string nodes, cells;
  for (const Brick& brick : bricks) {
    cells += std::to_string(&brick - bricks.data() + 1) + " 5 2 9 1";
    for (const double z : brick.z)
      for (const auto& [i, j] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
        const double x = brick.x[std::size_t(i)], y = brick.y[std::size_t(j)];
        const int next = int(number.size()) + 1;
        const auto [known, is_new] = number.try_emplace({x, y, z, brick.part}, next);
        if (is_new) nodes += fmt::format("{} {} {} {}\n", next, x, y, z);
        cells += " " + std::to_string(known->second);
      }
    cells += "\n";
  }
  return head_2 + fmt::format("$Nodes\n{}\n{}$EndNodes\n", number.size(), nodes) +
         elements_2(int(bricks.size()), cells);
}

std::string fault_of_solid(const std::vector<Brick>& bricks) {
  Faults faults;
  EXPECT_FALSE(parse_gmsh<3>(solid_of(bricks), "solid.msh", ElementKind::q1, faults));
  return faults.list().at(0).message;
}

TEST(GmshReader, FindsCellsOfASolidThatTouchWithoutSharingTheirNodes) {
  const Brick left{{0, 1}, {0, 1}, {0, 1}}, right{{1, 2}, {0, 1}, {0, 1}};
  EXPECT_THAT(fault_of_solid({left, right}), HasSubstr("has no physical group 'bottom'"));

  Brick own = right;
  own.part = 1;
  EXPECT_EQ(fault_of_solid({left, own}),
            "has cells that touch but are not joined, at 8 nodes, at first at (1, 0, 0) m: nodes 2 "
            "and 9 lie at one place");
  own.x[0] = 1.0000005;
  EXPECT_THAT(fault_of_solid({left, own}), HasSubstr("touch but are not joined, at 8 nodes"));
  own.x[0] = 1.5;
  EXPECT_THAT(fault_of_solid({left, own}), HasSubstr("lies in 2 pieces"));
  const Brick at_an_edge{{1, 2}, {1, 2}, {0, 1}};
  EXPECT_THAT(fault_of_solid({left, at_an_edge}), HasSubstr("lies in 2 pieces"));
}

TEST(GmshReader, FindsNodesThatHangInFacesAndEdgesOfASolid) {
  const Brick left{{0, 1}, {0, 1}, {0, 1}};
  EXPECT_EQ(fault_of_solid({left, {{1, 2}, {0, 1}, {0, 0.5}}, {{1, 2}, {0, 1}, {0.5, 1}}}),
            "has cells that touch but are not joined, at 2 nodes, at first at (1, 0, 0.5) m: node "
            "11 hangs in the side of a cell");
  // The corner of four bricks lies in the middle of the face.
  std::vector<Brick> quartered{left};
  for (const double y : {0.0, 0.3})
    for (const double z : {0.0, 0.6})
      quartered.push_back({{1, 2}, {y, y == 0.0 ? 0.3 : 1.0}, {z, z == 0.0 ? 0.6 : 1.0}});
  EXPECT_THAT(fault_of_solid(quartered), HasSubstr("at 5 nodes"));
  // Two meshes of one interface that share no node but the corners of its rim.
  EXPECT_THAT(fault_of_solid({{{0, 1}, {0, 1}, {0, 1}},
                              {{0, 1}, {1, 3}, {0, 1}},
                              {{1, 2}, {0, 2}, {0, 1}, 1},
                              {{1, 2}, {2, 3}, {0, 1}, 1}}),
              HasSubstr("touch but are not joined, at 12 nodes"));
}

TEST(GmshReader, RefusesUnknownGroupsEachOnce) {
  Faults faults;
  const std::string text =
      replaced(replaced(triangle_file, "\"top\"", "\"head\""), "\"side\"", "\"mould\"");
  EXPECT_FALSE(parse_gmsh<2>(text, "slab.msh", ElementKind::p1, faults));
  ASSERT_EQ(faults.list().size(), 2u);
  EXPECT_EQ(faults.list()[0].message, "has the unknown physical group 'mould'");
  EXPECT_EQ(faults.list()[1].message, "has the unknown physical group 'head'");
  EXPECT_EQ(faults.list()[0].permitted, "symmetry, bottom, side, top, or free");
}

TEST(GmshReader, WantsABottom) {
  std::string text = replaced(triangle_file, "2 1 2 2 2 13 12", "2 1 2 0 2 13 12");
  text = replaced(text, "3 1 2 2 2 11 12", "3 1 2 0 2 11 12");
  EXPECT_EQ(fault_of(text), "has no physical group 'bottom'");
}

TEST(GmshReader, RefusesTheWrongElementsOrAMixture) {
  EXPECT_EQ(fault_of(triangle_file, ElementKind::q1), "has triangles");
  EXPECT_EQ(fault_of(quadrilateral_file), "has quadrilaterals");

  const std::string mixture = head_2 + names + nodes_2 +
                              elements_2(9, boundary_2 +
                                                "7 2 2 7 1 11 12 22\n8 2 2 7 1 11 22 21\n"
                                                "9 3 2 7 1 12 13 23 22\n");
  EXPECT_EQ(fault_of(mixture), "has triangles and quadrilaterals");

  EXPECT_EQ(fault_of(head_2 + names + nodes_2 + elements_2(6, boundary_2)), "has no cells");
  EXPECT_THAT(fault_of(replaced(triangle_file, "7 2 2 7 1 11 12 22", "7 9 2 7 1 11 12 22 1 1 1")),
              HasSubstr("Gmsh's type 9; only linear ones are read"));
}

TEST(GmshReader, RefusesNodesThatDoNotFit) {
  std::string text = replaced(triangle_file, "$Nodes\n6\n", "$Nodes\n8\n31 5 5 0\n32 6 6 0\n");
  EXPECT_EQ(fault_of(text), "has 2 nodes that belong to no element");
  EXPECT_EQ(fault_of(replaced(triangle_file, "12 1 0 0", "12 1 0 0.5")),
            "has nodes with z other than 0");
  EXPECT_EQ(fault_of(replaced(triangle_file, "12 1 0 0", "11 1 0 0")), "has node 11 twice");
  EXPECT_EQ(fault_of(replaced(triangle_file, "12 1 0 0", "12 nan 0 0")),
            "has a coordinate that is not finite");
  EXPECT_EQ(fault_of(replaced(triangle_file, "12 1 0 0", "12 1e308 0 0")),
            "has a coordinate of 1e+308; lengths are in metres, at most 10000 of them");
  EXPECT_EQ(fault_of(replaced(triangle_file, "7 2 2 7 1 11 12 22", "7 2 2 7 1 11 12 99")),
            "has an element with the unknown node 99");
}

TEST(GmshReader, RefusesFoldedAndOverlappingElements) {
  EXPECT_THAT(fault_of(replaced(triangle_file, "12 1 0 0", "12 1 1 0")),
              HasSubstr("folded or flat"));
  EXPECT_THAT(fault_of(replaced(quadrilateral_file, "11 12 22 21", "11 12 21 22"), ElementKind::q1),
              HasSubstr("folded or flat"));

  std::string twice = replaced(triangle_file, "10 2 2 7 1 12 23 22", "10 2 2 7 1 11 12 22");
  twice = replaced(twice, "9 2 2 7 1 12 13 23", "9 2 2 7 1 11 12 22");
  EXPECT_NE(fault_of(twice), "");
}

TEST(GmshReader, RefusesFacetsOutOfPlace) {
  EXPECT_EQ(fault_of(replaced(triangle_file, "4 1 2 3 3 13 23", "4 1 2 3 3 12 22")),
            "has a facet of group side that is not on the boundary of the mesh");
  EXPECT_EQ(fault_of(replaced(triangle_file, "4 1 2 3 3 13 23", "4 1 2 3 3 11 12")),
            "has a facet in two groups, bottom and side");
}

TEST(GmshReader, RefusesOtherFormats) {
  EXPECT_EQ(fault_of(""), "does not begin with $MeshFormat: not a Gmsh mesh");
  EXPECT_THAT(fault_of(std::string(5000, '\0')), HasSubstr("not a Gmsh mesh"));
  EXPECT_THAT(fault_of(replaced(triangle_file, "2.2 0", "2.2 1")), HasSubstr("is binary"));
  EXPECT_THAT(fault_of(replaced(triangle_file, "2.2 0", "3 0")), HasSubstr("format version 3"));
  EXPECT_THAT(fault_of(replaced(triangle_file, "$Nodes\n6", "$Nodes\n1000000000000")),
              HasSubstr("ends in the middle of $Nodes"));
  EXPECT_THAT(fault_of(replaced(triangle_file, "12 1 0 0", "12 1,0 0 0")),
              HasSubstr("has '1,0' in $Nodes where a number belongs"));
}

TEST(GmshReader, RefusesAFileWhereverItIsCut) {
  for (const std::string& text : {triangle_file, triangle_file_4})
    for (std::size_t size = 0; size + 1 < text.size(); ++size)
      EXPECT_NE(fault_of(text.substr(0, size)), "") << "cut to " << size;
}

/// Each element has all groups of its entity: a hundred thousand of both took 40 GB.
TEST(GmshReader, RefusesAnEntityInMoreGroupsThanAnyoneNeeds) {
  std::string groups = " 101";
  for (int i = 0; i < 101; ++i) groups += " 7";
  EXPECT_EQ(fault_of(replaced(triangle_file_4, "1 0 0 0 2 1 0 1 7", "1 0 0 0 2 1 0" + groups)),
            "has an entity in more than 100 physical groups");
}

TEST(GmshReader, NamesAFileThatIsNotThere) {
  for (const auto& path : {std::filesystem::path("nowhere.msh"), std::filesystem::path(".")}) {
    Faults faults;
    EXPECT_FALSE(read_gmsh<2>(path, ElementKind::p1, faults));
    ASSERT_EQ(faults.list().size(), 1u);
    EXPECT_EQ(faults.list()[0].value, path.filename().string());
    EXPECT_EQ(faults.list()[0].message, "cannot be read");
  }
}

}  // namespace
}  // namespace dccast::mesh
