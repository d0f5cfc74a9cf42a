// The fields of a frame: whole, one at a time, or at points.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/fem/point_location.hpp"
#include "core/mesh/mesh.hpp"
#include "server/translate/translate.hpp"

namespace dccast::translate {

namespace {

template <class Numbers, class Field>
void fill(const Numbers& from, Field* to) {
  to->Add(from.begin(), from.end());
}

/// A field of a frame with one number for each node or element.
struct ScalarField {
  const char* name;
  const char* unit;
  const char* meaning;
  bool on_nodes;
  std::vector<double> values;
};

/// The fields that are worth a picture: those with one component, and the largest principal stress.
/// Temperature comes with every frame; the solid fraction stands for the liquid one.
std::vector<ScalarField> scalar_fields(const results::Frame& frame) {
  std::vector<ScalarField> fields;
  for (const results::FrameArray& array : results::frame_arrays()) {
    const std::vector<double>& values = frame.*array.values;
    const bool drawn = array.rank == results::FrameArray::Rank::scalar &&
                       array.on != results::FrameArray::On::bottom &&
                       array.values != &results::Frame::temperature &&
                       array.values != &results::Frame::liquid_fraction;
    if (drawn && !values.empty())
      fields.push_back({array.dataset, array.unit, array.meaning,
                        array.on == results::FrameArray::On::nodes, values});
  }

  for (results::DerivedField& field : results::derived_fields(frame)) {
    if (field.components == 1) {
      fields.push_back(
          {field.name, field.unit, field.meaning, field.on_nodes, std::move(field.values)});
    } else if (std::string_view(field.name) == "principal_stress_pa") {
      std::vector<double> largest;
      for (std::size_t i = 0; i < field.values.size(); i += 3) largest.push_back(field.values[i]);
      fields.push_back({field.name, field.unit, "largest principal stress, tension positive",
                        field.on_nodes, std::move(largest)});
    }
  }
  return fields;
}

void describe(const ScalarField& field, v1::FrameField& to) {
  to.set_name(field.name);
  to.set_unit(field.unit);
  to.set_meaning(field.meaning);
  to.set_on_nodes(field.on_nodes);
}

/// The columns of a probe that every frame has: temperature and the components of the displacement.
std::vector<ScalarField> basic_fields(const results::Frame& frame) {
  std::vector<ScalarField> fields{
      {"temperature_c", "degC", "temperature", true, frame.temperature}};

  static constexpr std::array names{"displacement_x_m", "displacement_y_m", "displacement_z_m"};
  const auto dimension = std::size_t(frame.dimension);
  for (std::size_t axis = 0; axis < dimension; ++axis) {
    std::vector<double> component;  // empty in a run without mechanics
    for (std::size_t n = axis; n < frame.displacement.size(); n += dimension)
      component.push_back(frame.displacement[n]);
    fields.push_back({names[axis], "m", "displacement", true, std::move(component)});
  }
  return fields;
}

/// One field for each column. A field that the frame does not have has neither unit nor values.
std::vector<ScalarField> probed_fields(const results::Frame& frame,
                                       const v1::ProbeResultRequest& request) {
  std::vector<ScalarField> fields = basic_fields(frame);
  if (request.fields().empty()) return fields;

  const std::vector<ScalarField> others = scalar_fields(frame);
  for (const std::string& name : request.fields()) {
    const auto found =
        std::ranges::find_if(others, [&](const ScalarField& field) { return field.name == name; });
    fields.push_back(found != others.end() ? *found : ScalarField{name.c_str(), "", "", true, {}});
  }
  return fields;
}

template <int Dim>
void add_values(const results::Frame& frame, const v1::ProbeResultRequest& request,
                const std::vector<ScalarField>& fields, v1::ProbeResultResponse::Instant& instant) {
  mesh::Mesh<Dim> mesh;
  mesh.node = frame.node;
  mesh.nodes_per_element = frame.nodes_per_element;
  mesh.element_node.assign(frame.element_node.begin(), frame.element_node.end());

  for (const auto& asked : request.points()) {
    std::array<double, Dim> point{};
    std::copy_n(asked.coordinate_m().begin(), Dim, point.begin());
    const std::optional<fem::Place> place = fem::locate<Dim>(mesh, point);

    for (const ScalarField& field : fields) {
      double value = 0.0;
      if (!place || field.values.empty())
        value = std::numeric_limits<double>::quiet_NaN();
      else if (field.on_nodes)
        value = fem::interpolate(mesh, *place, field.values);
      else
        value = field.values[std::size_t(place->element)];
      instant.add_values(value);
    }
  }
}

}  // namespace

v1::Frame field_to_proto(const results::Frame& frame, const std::string& name) {
  v1::Frame to;
  to.set_time_s(frame.time);
  to.set_cast_length_m(frame.cast_length);
  for (const ScalarField& field : scalar_fields(frame)) {
    if (field.name != name) continue;
    describe(field, *to.mutable_field());
    to.mutable_field()->mutable_values()->Add(field.values.begin(), field.values.end());
  }
  return to;
}

v1::Frame to_proto(const results::Frame& frame, const results::RunHeader& header) {
  v1::Frame to;
  to.set_time_s(frame.time);
  to.set_cast_length_m(frame.cast_length);
  to.set_dimension(frame.dimension);
  to.set_nodes_per_element(frame.nodes_per_element);

  fill(frame.node, to.mutable_node_m());
  fill(frame.element_node, to.mutable_element_node());

  fill(frame.temperature, to.mutable_temperature_c());
  fill(frame.displacement, to.mutable_displacement_m());
  fill(frame.bottom_node, to.mutable_bottom_node());
  fill(frame.bottom_gap, to.mutable_bottom_gap_m());
  fill(frame.bottom_pressure, to.mutable_bottom_pressure_pa());

  to.set_metal_level_m(frame.metal_level);
  to.set_liquidus_c(header.liquidus);
  to.set_solidus_c(header.solidus);
  to.set_shell_c(header.shell);

  for (const ScalarField& field : scalar_fields(frame)) describe(field, *to.add_fields());
  return to;
}

void add_probed(const results::Frame& frame, const v1::ProbeResultRequest& request,
                v1::ProbeResultResponse& response) {
  const std::vector<ScalarField> fields = probed_fields(frame, request);
  while (response.fields_size() < int(fields.size())) response.add_fields();

  // A field may be absent from the first frames only.
  for (std::size_t i = 0; i < fields.size(); ++i) {
    v1::FrameField& described = *response.mutable_fields(int(i));
    if (described.unit().empty()) describe(fields[i], described);
  }

  auto& instant = *response.add_instants();
  instant.set_time_s(frame.time);
  instant.set_cast_length_m(frame.cast_length);
  if (frame.dimension == 2)
    add_values<2>(frame, request, fields, instant);
  else
    add_values<3>(frame, request, fields, instant);
}

}  // namespace dccast::translate
