#include "core/results/xdmf.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/storage/file.hpp"
#include "tests/unit/results/sample_run.hpp"

namespace dccast::results {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string sidecar_of(const Frame& frame) {
  const TemporaryFolder folder;
  ResultWriter writer({folder / "j", folder / "r.h5"}, sample_header());
  writer.append(frame);
  writer.publish({});
  return storage::read_file(folder / "r.xdmf");
}

TEST(Xdmf, ShowsTrianglesAndQuadrilaterals) {
  EXPECT_THAT(sidecar_of(sample_frame(3, 3, 2)),
              HasSubstr(R"(TopologyType="Triangle" NumberOfElements="4"><DataItem Format="HDF" )"
                        R"(Dimensions="4 3" NumberType="Int" Precision="4">)"
                        R"(r.h5:/frames/000000/element_node<)"));
  EXPECT_THAT(sidecar_of(sample_frame(3, 4, 2)), HasSubstr(R"(TopologyType="Quadrilateral")"));
}

TEST(Xdmf, ShowsSolidElements) {
  Frame frame = sample_frame(3, 4, 2);
  frame.stress.clear();
  frame.viscoplastic_strain.clear();
  frame.thermal_strain.clear();
  frame.tear_rate.clear();
  frame.tear_pressure.clear();
  frame.displacement.clear();
  frame.temperature.clear();
  frame.liquid_fraction.clear();
  frame.dimension = 3;         // its 12 numbers are four points now
  frame.bottom_node = {0, 2};  // the third would lie beyond them
  frame.bottom_gap.resize(2);
  frame.bottom_pressure.resize(2);
  frame.element_node = {0, 1, 2, 3};
  EXPECT_THAT(sidecar_of(frame), HasSubstr(R"(TopologyType="Tetrahedron")"));
  EXPECT_THAT(sidecar_of(frame),
              HasSubstr(R"(GeometryType="XYZ"><DataItem Format="HDF" Dimensions="4 3")"));
  frame.nodes_per_element = 8;
  frame.element_node = {0, 1, 2, 3, 0, 1, 2, 3};
  EXPECT_THAT(sidecar_of(frame), HasSubstr(R"(TopologyType="Hexahedron")"));
}

/// meshio reads no collections and no times.
TEST(Xdmf, TheLastFrameAloneIsOneUniformGrid) {
  const std::vector<FrameOutline> frames(3, make_outline(sample_frame(3, 4, 2)));
  const std::string text = format_last_frame(frames, "r.h5");
  EXPECT_THAT(text, HasSubstr("r.h5:/frames/000002/node_m<"));
  EXPECT_THAT(text, Not(HasSubstr("/frames/000001/")));
  EXPECT_THAT(text, Not(HasSubstr("Collection")));
  EXPECT_THAT(text, Not(HasSubstr("<Time")));
}

TEST(Xdmf, CentresStressesOnCellsAndLeavesOutWhatIsNotThere) {
  Frame frame = sample_frame(3, 3, 2);
  EXPECT_THAT(sidecar_of(frame),
              HasSubstr(R"(Name="stress_pa" AttributeType="Matrix" Center="Cell")"));
  EXPECT_THAT(sidecar_of(frame),
              HasSubstr(R"(Name="temperature_c" AttributeType="Scalar" Center="Node")"));
  frame.stress.clear();
  EXPECT_THAT(sidecar_of(frame), Not(HasSubstr("stress_pa")));
}

/// ParaView's Warp By Vector takes vectors of three components and nothing else.
TEST(Xdmf, GivesThePlaneDisplacementThreeComponents) {
  EXPECT_THAT(sidecar_of(sample_frame(3, 3, 2)),
              HasSubstr(R"(Name="displacement_m" AttributeType="Vector" Center="Node"><DataItem )"
                        R"(Format="HDF" Dimensions="6 3" NumberType="Float" Precision="8">)"
                        R"(r.h5:/frames/000000/displacement_xyz_m<)"));
}

TEST(Xdmf, ShowsWhatFollowsFromTheFields) {
  const std::string text = sidecar_of(sample_frame(3, 3, 2));
  EXPECT_THAT(text, HasSubstr(R"(Name="von_mises_pa" AttributeType="Scalar" Center="Cell")"));
  EXPECT_THAT(text, HasSubstr(R"(Name="solid_fraction" AttributeType="Scalar" Center="Node")"));
  EXPECT_THAT(text,
              HasSubstr(R"(Name="contact_pressure_pa" AttributeType="Scalar" Center="Node")"));
  for (const char* name : {"thermal_strain", "gap_m"})
    EXPECT_THAT(text, HasSubstr("Name=\"" + std::string(name) +
                                "\" AttributeType=\"Scalar\" Center=\"Node\""));
  for (const char* name : {"mean_stress_pa", "equivalent_viscoplastic_strain"})
    EXPECT_THAT(text, HasSubstr("Name=\"" + std::string(name) +
                                "\" AttributeType=\"Scalar\" Center=\"Cell\""));
  EXPECT_THAT(text,
              HasSubstr(R"(Name="principal_stress_pa" AttributeType="Vector" Center="Cell")"));
}

TEST(Xdmf, GivesTheTimeExactly) {
  EXPECT_THAT(sidecar_of(sample_frame(1, 3, 2)),
              HasSubstr(R"(<Time Value="0.33333333333333331"/>)"));
}

TEST(Xdmf, RefersToTheFileUnderTheNameGiven) {
  EXPECT_THAT(format_xdmf({make_outline(sample_frame(0, 3, 2))}, "a & b.h5"),
              HasSubstr(">a &amp; b.h5:/frames/000000/node_m<"));
}

}  // namespace
}  // namespace dccast::results
