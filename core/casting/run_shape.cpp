#include "core/casting/run_shape.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <vector>

#include "core/casting/findings/motion.hpp"

namespace dccast::casting {

namespace {

constexpr double same_height = 1e-9;  // [m]

/// Collects the first reason against a state.
class Reasons {
public:
  void require(bool good, const std::string& otherwise) {
    if (!good && first_.empty()) first_ = otherwise;
  }
  template <class Array>
  void require_size(const Array& array, std::size_t size, const std::string& name) {
    require(array.size() == size, name + " has " + std::to_string(array.size()) + " values for " +
                                      std::to_string(size) + " on the mesh");
  }
  void require_finite(const std::vector<double>& array, const std::string& name) {
    require(std::ranges::all_of(array, [](double v) { return std::isfinite(v); }),
            name + " has values that are not finite");
  }
  void require_reals(const std::vector<double>& array, std::size_t size, const std::string& name) {
    require_size(array, size, name);
    require_finite(array, name);
  }
  template <int Dim>
  void require_tensors(const std::vector<SymmetricTensor<Dim>>& array, std::size_t size,
                       const std::string& name) {
    require_size(array, size, name);
    for (const auto& tensor : array)
      require(std::ranges::all_of(tensor.value, [](double v) { return std::isfinite(v); }),
              name + " has values that are not finite");
  }
  const std::string& first() const { return first_; }

private:
  std::string first_;
};

/// Sizes of the arrays of a state required by a mesh.
struct Shape {
  std::size_t nodes, elements, points, bottom_nodes;
};

/// The same by the mesh of the heat and by that of the mechanics.
struct Shapes {
  Shape heat, mechanics;
};

void fit_heat(const thermal::HeatField& heat, const Shape& shape, Reasons& reasons) {
  reasons.require_reals(heat.enthalpy, shape.nodes, "enthalpy");
  reasons.require_reals(heat.temperature, shape.nodes, "temperature");
  reasons.require_reals(heat.liquid_fraction, shape.nodes, "liquid fraction");
  // Empty before the first step, and where the temperature is prescribed.
  if (!heat.enthalpy_rate.empty())
    reasons.require_reals(heat.enthalpy_rate, shape.nodes, "enthalpy rate");
  // Empty before the first step, and without `boiling_follows_flow`.
  if (!heat.wetted.empty())
    reasons.require_reals(heat.wetted, thermal::faces * shape.nodes, "wetted share");
  // Empty before the first step, and where the block keeps its temperature.
  if (!heat.block_temperature.empty())
    reasons.require_reals(heat.block_temperature,
                          thermal::BlockColumns::points * shape.bottom_nodes, "block temperature");
  // Empty before the first step, and without water that runs into the gap.
  if (!heat.gap_wetted.empty())
    reasons.require_reals(heat.gap_wetted, shape.bottom_nodes, "wetted share of the bottom");
}

template <int Dim>
void fit_slab(const mechanics::SlabState<Dim>& slab, const Shape& shape, Reasons& reasons) {
  reasons.require_reals(slab.displacement, Dim * shape.nodes, "displacement");
  reasons.require_size(slab.solid, shape.elements, "solid elements");
  reasons.require_size(slab.carries, shape.elements, "elements that carry load");
  reasons.require_tensors(slab.inelastic, shape.points, "inelastic strain");
  reasons.require_tensors(slab.viscoplastic, shape.points, "viscoplastic strain");
  if (!slab.hardened.empty()) reasons.require_reals(slab.hardened, shape.points, "hardened strain");
  reasons.require_tensors(slab.deviator, shape.points, "stress deviator");
  reasons.require_reals(slab.pressure, shape.points, "pressure");
  reasons.require_size(slab.contact, shape.bottom_nodes, "contact");
  reasons.require_size(slab.leaning, Dim * shape.nodes, "directions that lean on the mould");
  reasons.require_reals(slab.reaction, shape.bottom_nodes, "reaction");
  // Empty before the first step, and with any algorithm except sbm.
  if (!slab.contact_multiplier.empty())
    reasons.require_reals(slab.contact_multiplier, shape.bottom_nodes, "contact multiplier");
}

template <int Dim>
void fit_course(const RunState<Dim>& state, const RunShape<Dim>& run, Reasons& reasons) {
  const CastingSchedule& schedule = run.schedule;
  reasons.require(state.step >= 0, "its step is negative");
  reasons.require(state.time >= schedule.begin() && state.time <= schedule.end() + 1e-9,
                  "its time is outside the run");
  reasons.require(state.next_frame >= schedule.begin() && std::isfinite(state.next_frame),
                  "the time of its next frame is outside the run");
  reasons.require(state.step_limit >= run.casting_case.time.minimum_step,
                  "its time step is too small");
  reasons.require(std::isfinite(state.cast_length), "its cast length is not finite");
}

template <int Dim>
void fit_rows(const RunState<Dim>& state, const RunShape<Dim>& run, Reasons& reasons) {
  const auto& heights = state.row_heights;
  const mesh::SlabMesh<Dim>* slab = run.mesh.in_rows();
  if (slab == nullptr) {
    reasons.require(heights.empty(), "it has rows, but the mesh has none");
    return;
  }
  reasons.require_finite(heights, "row heights");
  reasons.require(heights.size() > std::size_t(slab->rows()), "it has too few rows");
  reasons.require(std::ranges::is_sorted(heights, std::less_equal{}), "its rows do not ascend");
  if (!reasons.first().empty()) return;
  const double level = run.mesh.level_at(run.schedule, state.time, state.cast_length);
  reasons.require(std::abs(heights.back() - level) <= same_height,
                  "its rows do not end at its metal level");
}

/// Checks against the mesh given by the rows of a state.
template <int Dim>
Shapes shapes_of(const RunState<Dim>& state, const RunShape<Dim>& run) {
  const auto of_mesh = [](const mesh::Mesh<Dim>& mesh) {
    return Shape{std::size_t(mesh.nodes()), std::size_t(mesh.elements()), 0,
                 mesh::patch_nodes(mesh, mesh::PatchKind::bottom).size()};
  };
  Shapes shapes{of_mesh(run.mesh.heat_mesh()), of_mesh(run.mesh.mesh())};

  if (const mesh::SlabMesh<Dim>* slab = run.mesh.in_rows()) {
    const std::size_t rows = state.row_heights.size();
    shapes.heat.nodes = rows * std::size_t(slab->heat_nodes_per_row());
    shapes.heat.elements = (rows - 1) * std::size_t(slab->heat_elements_per_row());
    shapes.mechanics.nodes = rows * std::size_t(slab->nodes_per_row());
    shapes.mechanics.elements = (rows - 1) * std::size_t(slab->elements_per_row());
  }
  for (Shape* shape : {&shapes.heat, &shapes.mechanics})
    shape->points = shape->elements * run.points;
  return shapes;
}

}  // namespace

template <int Dim>
std::string misfit(const RunState<Dim>& state, const RunShape<Dim>& run) {
  Reasons reasons;
  fit_course(state, run, reasons);

  fit_rows(state, run, reasons);
  if (!reasons.first().empty()) return reasons.first();
  const auto [heat, mechanics] = shapes_of(state, run);
  fit_heat(state.heat, heat, reasons);
  fit_slab(state.slab, mechanics, reasons);

  reasons.require_reals(state.curl.curl, state.curl.time.size(), "curl of the last minute");
  reasons.require_finite(state.curl.time, "time of the last minute");

  const std::vector<double>& when_liquid = state.findings.history.when_liquid;
  if (!when_liquid.empty())  // before the mechanics begins nothing turns
    reasons.require_reals(when_liquid, mechanics.elements * std::tuple_size_v<Turn<Dim>>,
                          "rotation when liquid");
  // Without a window of hot tears nothing is followed.
  if (!state.findings.history.passages.empty())
    reasons.require_size(state.findings.history.passages, heat.elements, "passage of the mush");

  for (const Finding& finding : state.findings.raised) {
    if (!finding.place.empty()) reasons.require_reals(finding.place, Dim, "the place of a finding");
    if (finding.worst && !finding.worst->place.empty())
      reasons.require_reals(finding.worst->place, Dim, "the place of a finding");
  }
  for (const results::Margin& margin : state.findings.margins)
    if (!margin.worst.place.empty())
      reasons.require_reals(margin.worst.place, Dim, "the place of a margin");
  return reasons.first();
}

template std::string misfit(const RunState<2>&, const RunShape<2>&);
template std::string misfit(const RunState<3>&, const RunShape<3>&);

}  // namespace dccast::casting
