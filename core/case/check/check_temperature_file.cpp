#include "core/case/check/checks.hpp"

#include "core/mesh/slab_mesh.hpp"
#include "core/prescribed/temperature_file.hpp"

namespace dccast::casting {

namespace {

/// Empty if the check is skipped because of another fault.
std::optional<std::size_t> nodes_at_the_start(CaseFindings& found) {
  if (found.imported_plane) return std::size_t(found.imported_plane->nodes());
  if (found.imported_solid) return std::size_t(found.imported_solid->nodes());
  if (!found.sound({"mesh.file"}) || !found.sound(grid_keys) || !found.sound(place_keys))
    return std::nullopt;
  const mesh::SectionSpec& s = found.casting.section;
  return std::size_t(found.solid() ? mesh::SlabMesh3D(s).mesh().nodes()
                                   : mesh::SlabMesh2D(s).mesh().nodes());
}

void temperature_range(CaseFindings& found, const prescribed::TemperatureHistory& history) {
  if (history.begin() <= -found.casting.schedule.hold + 1e-9 &&
      history.end() >= found.casting.time.end - 1e-9) {
    return;
  }
  found.warning("thermal.file", found.casting.thermal.file.filename().string(),
                "does not cover the simulated time; its first and last temperatures are "
                "held outside",
                "from " + with_unit(-found.casting.schedule.hold, "s") + " to " +
                    with_unit(found.casting.time.end, "s"));
}

}  // namespace

void check_temperature_file(CaseFindings& found) {
  if (found.casting.thermal.file.empty() || !found.sound({"thermal.file"})) return;
  const auto nodes = nodes_at_the_start(found);
  if (!nodes) return;
  const auto history =
      prescribed::read_temperature_file(found.casting.thermal.file, *nodes, found.faults);
  if (history && found.sound({"time.end", "schedule.hold"})) temperature_range(found, *history);
}

}  // namespace dccast::casting
