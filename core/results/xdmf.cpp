#include "core/results/xdmf.hpp"

#include <cstdio>

#include "core/results/result_reader.hpp"

namespace dccast::results {

namespace {

const char* topology_of(const FrameOutline& frame) {
  if (frame.nodes_per_element == 3) return "Triangle";
  if (frame.nodes_per_element == 8) return "Hexahedron";
  return frame.dimension == 2 ? "Quadrilateral" : "Tetrahedron";
}

/// Tensors are matrices: with its four components in plane strain none of XDMF's tensor types fits.
const char* type_of(const ShownField& field) {
  if (field.components == 1) return "Scalar";
  return field.components == 3 ? "Vector" : "Matrix";
}

std::string exact(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string escaped(const std::string& text) {
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
  return "<DataItem Format=\"HDF\" Dimensions=\"" + dimensions + "\" NumberType=\"" + number +
         "\" Precision=\"" + std::to_string(precision) + "\">" + address + "</DataItem>";
}

std::string rows(std::int64_t count, int columns) {
  std::string text = std::to_string(count);
  if (columns != 1) text.append(1, ' ').append(std::to_string(columns));
  return text;
}

std::string attribute(const FrameOutline& frame, const ShownField& field,
                      const std::string& group) {
  const std::string size = rows(field.on_nodes ? frame.nodes : frame.elements, field.components);
  return "        <Attribute Name=\"" + field.name + "\" AttributeType=\"" + type_of(field) +
         "\" Center=\"" + (field.on_nodes ? "Node" : "Cell") + "\">" +
         data_item(size, "Float", 8, group + "/" + field.dataset) + "</Attribute>\n";
}

std::string grid(const FrameOutline& frame, const std::string& group) {
  std::string text = "      <Grid Name=\"slab\" GridType=\"Uniform\">\n";
  text += "        <Time Value=\"" + exact(frame.time) + "\"/>\n";
  text +=
      "        <Topology TopologyType=\"" + std::string(topology_of(frame)) +
      "\" NumberOfElements=\"" + std::to_string(frame.elements) + "\">" +
      data_item(rows(frame.elements, frame.nodes_per_element), "Int", 4, group + "/element_node") +
      "</Topology>\n";
  text += std::string("        <Geometry GeometryType=\"") + (frame.dimension == 2 ? "XY" : "XYZ") +
          "\">" + data_item(rows(frame.nodes, frame.dimension), "Float", 8, group + "/node_m") +
          "</Geometry>\n";
  for (const ShownField& field : frame.fields) text += attribute(frame, field, group);
  return text + "      </Grid>\n";
}

}  // namespace

FrameOutline outline_of(const Frame& frame) {
  FrameOutline outline{frame.time,    frame.dimension,  frame.nodes_per_element,
                       frame.nodes(), frame.elements(), {}};
  for (const auto on : {FrameArray::On::nodes, FrameArray::On::elements})
    for (const FrameArray& array : frame_arrays()) {
      if (array.on != on || (frame.*array.values).empty()) continue;
      // Of a plane displacement the one with three components is shown.
      if (frame.dimension == 2 && array.rank == FrameArray::Rank::vector) continue;
      outline.fields.push_back({array.dataset, array.dataset, on == FrameArray::On::nodes,
                                array.components(frame.dimension)});
    }
  for (const DerivedField& field : derived_fields(frame)) {
    // What ParaView warps by has one name in two and in three dimensions.
    const std::string dataset = field.name;
    const bool padded = dataset == "displacement_xyz_m";
    outline.fields.push_back(
        {padded ? "displacement_m" : dataset, dataset, field.on_nodes, field.components});
  }
  return outline;
}

std::string xdmf_of(const std::vector<FrameOutline>& frames, const std::string& hdf5_name) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
      "    <Grid Name=\"casting\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (std::size_t i = 0; i < frames.size(); ++i)
    text += grid(frames[i], escaped(hdf5_name) + ":" + frame_group(i));
  return text + "    </Grid>\n  </Domain>\n</Xdmf>\n";
}

}  // namespace dccast::results
