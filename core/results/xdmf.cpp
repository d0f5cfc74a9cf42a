#include "core/results/xdmf.hpp"

#include <cstdio>
#include <string_view>

#include "core/results/result_file.hpp"

namespace dccast::results {

namespace {

const char* topology_of(const FrameOutline& frame) {
  if (frame.nodes_per_element == 3) return "Triangle";
  if (frame.nodes_per_element == 8) return "Hexahedron";
  return frame.dimension == 2 ? "Quadrilateral" : "Tetrahedron";
}

/// A field as XDMF sees it. Tensors are matrices: with its four components in plane strain none of
/// XDMF's tensor types fits.
struct Field {
  const char* type;
  const char* center;
  int components;
};

Field field_of(std::string_view dataset, int dimension) {
  if (dataset == "displacement_m") return {dimension == 3 ? "Vector" : "Matrix", "Node", dimension};
  if (dataset == "stress_pa" || dataset == "viscoplastic_strain")
    return {"Matrix", "Cell", tensor_components(dimension)};
  return {"Scalar", "Node", 1};
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

std::string attribute(const FrameOutline& frame, const std::string& dataset,
                      const std::string& group) {
  const Field field = field_of(dataset, frame.dimension);
  const bool on_nodes = std::string_view(field.center) == "Node";
  const std::string size = rows(on_nodes ? frame.nodes : frame.elements, field.components);
  return "        <Attribute Name=\"" + dataset + "\" AttributeType=\"" + field.type +
         "\" Center=\"" + field.center + "\">" +
         data_item(size, "Float", 8, group + "/" + dataset) + "</Attribute>\n";
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
  for (const std::string& dataset : frame.datasets) text += attribute(frame, dataset, group);
  return text + "      </Grid>\n";
}

}  // namespace

FrameOutline outline_of(const Frame& frame) {
  FrameOutline outline{frame.time,    frame.dimension,  frame.nodes_per_element,
                       frame.nodes(), frame.elements(), {}};
  const auto add = [&](const char* dataset, const std::vector<double>& values) {
    if (!values.empty()) outline.datasets.emplace_back(dataset);
  };
  add("temperature_c", frame.temperature);
  add("liquid_fraction", frame.liquid_fraction);
  add("displacement_m", frame.displacement);
  add("stress_pa", frame.stress);
  add("viscoplastic_strain", frame.viscoplastic_strain);
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
