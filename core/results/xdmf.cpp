#include "core/results/xdmf.hpp"

#include <fmt/format.h>

#include "core/results/result_reader.hpp"

namespace dccast::results {

namespace {

const char* topology_name(const FrameOutline& frame) {
  if (frame.nodes_per_element == 3) return "Triangle";
  if (frame.nodes_per_element == 8) return "Hexahedron";
  return frame.dimension == 2 ? "Quadrilateral" : "Tetrahedron";
}

/// Tensors are written as matrices, because no tensor type of XDMF has the four components of plane
/// strain.
const char* attribute_type(const ShownField& field) {
  if (field.components == 1) return "Scalar";
  return field.components == 3 ? "Vector" : "Matrix";
}

/// Escapes the characters that XML reserves.
std::string escape(const std::string& text) {
  std::string safe;

  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '"')
      safe += "&quot;";
    else
      safe += c;
  }

  return safe;
}

std::string data_item(const std::string& dimensions, const char* number, int precision,
                      const std::string& address) {
  return fmt::format(
      R"(<DataItem Format="HDF" Dimensions="{}" NumberType="{}" Precision="{}">{}</DataItem>)",
      dimensions, number, precision, address);
}

/// Dimensions of an array with one row per node or element.
std::string row_dimensions(std::int64_t count, int columns) {
  return columns == 1 ? fmt::format("{}", count) : fmt::format("{} {}", count, columns);
}

std::string attribute(const FrameOutline& frame, const ShownField& field,
                      const std::string& group) {
  const std::string size =
      row_dimensions(field.on_nodes ? frame.nodes : frame.elements, field.components);
  return fmt::format(R"(        <Attribute Name="{}" AttributeType="{}" Center="{}">{}</Attribute>)"
                     "\n",
                     field.name, attribute_type(field), field.on_nodes ? "Node" : "Cell",
                     data_item(size, "Float", 8, fmt::format("{}/{}", group, field.dataset)));
}

/// @param timed  with its time, for a collection
std::string grid(const FrameOutline& frame, const std::string& group, bool timed) {
  std::string text = "      <Grid Name=\"slab\" GridType=\"Uniform\">\n";
  if (timed) text += fmt::format("        <Time Value=\"{:.17g}\"/>\n", frame.time);

  // Mesh and fields stay in the HDF5 file; the text only refers to them.
  text += fmt::format(R"(        <Topology TopologyType="{}" NumberOfElements="{}">{}</Topology>)"
                      "\n",
                      topology_name(frame), frame.elements,
                      data_item(row_dimensions(frame.elements, frame.nodes_per_element), "Int", 4,
                                group + "/element_node"));
  text += fmt::format(
      R"(        <Geometry GeometryType="{}">{}</Geometry>)"
      "\n",
      frame.dimension == 2 ? "XY" : "XYZ",
      data_item(row_dimensions(frame.nodes, frame.dimension), "Float", 8, group + "/node_m"));

  for (const ShownField& field : frame.fields) text += attribute(frame, field, group);
  text += "      </Grid>\n";
  return text;
}

}  // namespace

FrameOutline make_outline(const Frame& frame) {
  FrameOutline outline{frame.time,    frame.dimension,  frame.nodes_per_element,
                       frame.nodes(), frame.elements(), {}};

  for (const auto on : {FrameArray::On::nodes, FrameArray::On::elements})
    for (const FrameArray& array : frame_arrays()) {
      if (array.on != on || (frame.*array.values).empty()) continue;

      // In 2D the derived displacement with three components is shown instead.
      if (frame.dimension == 2 && array.rank == FrameArray::Rank::vector) continue;
      outline.fields.push_back({array.dataset, array.dataset, on == FrameArray::On::nodes,
                                array.components(frame.dimension)});
    }

  for (const DerivedField& field : derived_fields(frame)) {
    // The field by which ParaView warps has the same name in 2D and 3D.
    const std::string dataset = field.name;
    const bool padded = dataset == "displacement_xyz_m";
    outline.fields.push_back(
        {padded ? "displacement_m" : dataset, dataset, field.on_nodes, field.components});
  }
  return outline;
}

std::string format_xdmf(const std::vector<FrameOutline>& frames, const std::string& hdf5_name) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
      "    <Grid Name=\"casting\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (std::size_t i = 0; i < frames.size(); ++i)
    text += grid(frames[i], fmt::format("{}:{}", escape(hdf5_name), frame_group(i)), true);
  text += "    </Grid>\n  </Domain>\n</Xdmf>\n";
  return text;
}

std::string format_last_frame(const std::vector<FrameOutline>& frames,
                              const std::string& hdf5_name) {
  std::string text = "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n";
  if (!frames.empty())
    text += grid(frames.back(),
                 fmt::format("{}:{}", escape(hdf5_name), frame_group(frames.size() - 1)), false);
  return text + "  </Domain>\n</Xdmf>\n";
}

}  // namespace dccast::results
