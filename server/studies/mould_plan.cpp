// The mould opening that gives a flat cold slab: run by run the opening is corrected by what the
// slab of the runs before it lacked.
#include <algorithm>
#include <cmath>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/quantity.hpp"
#include "server/intake/case_intake.hpp"
#include "server/studies/mould_opening.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

namespace {

using intake::fault_of;

constexpr int usual_runs = 12, fewest_runs = 2, most_runs_permitted = 50;
constexpr double least_tolerance = 1e-5, most_tolerance = 0.05;  // [m]
// No alloy pulls in by more than a tenth; a third leaves room for a search that overshoots.
constexpr double widest_opening = 1.3;       // of the half-thickness that is wanted
constexpr double shortest_segment = 0.1;     // of half the face
constexpr double columns_per_segment = 1.5;  // so that each break point finds a row of nodes
constexpr int columns_unknown = 10;
constexpr double on_the_face = 1e-6;  // [m] from a monitor to the mould

/// Millimetres without the round-off of their conversion.
std::string in_mm(double metres) {
  constexpr double per_mm = 1e6;
  return case_file::quantity_text(std::round(1e3 * metres * per_mm) / per_mm, "mm");
}

/// Faults of single values of the plan.
std::vector<v1::Fault> plan_value_faults(const v1::MouldPlan& plan) {
  std::vector<v1::Fault> faults;
  if (!(plan.tolerance_m() >= least_tolerance && plan.tolerance_m() <= most_tolerance))
    faults.push_back(fault_of("mould.tolerance", in_mm(plan.tolerance_m()), "is out of range",
                              "0.01 to 50 mm", "0.5 mm is what moulds are made to"));

  if (plan.maximum_runs() != 0 &&
      (plan.maximum_runs() < fewest_runs || plan.maximum_runs() > most_runs_permitted))
    faults.push_back(fault_of("mould.maximum_runs", std::to_string(plan.maximum_runs()),
                              "is out of range", "2 to 50; 0 for 12",
                              "one run shows what its own mould gives: dccast contraction"));

  const double wanted = plan.wanted_half_thickness_m();
  if (!(wanted == 0.0 || (wanted >= 0.005 && wanted <= 3.0)))
    faults.push_back(fault_of("mould.wanted_half_thickness", in_mm(wanted), "is out of range",
                              "0.005 to 3 m; 0 for the opening at the narrow face",
                              "give half the thickness of the cold slab"));

  return faults;
}

/// Faults of a section that has no wide face, or no mould to begin with.
std::vector<v1::Fault> section_faults(const v1::Case& base) {
  const v1::Section& section = base.section();
  if (section.kind() != v1::Section::QUARTER_SLAB)
    return {fault_of("section.kind",
                     section.kind() == v1::Section::AXISYMMETRIC ? "axisymmetric" : "plane_strain",
                     "has no wide face whose mould could be designed", "quarter_slab",
                     "begin with dccast new stationary-3d")};

  if (section.half_thickness_m().value_size() == 0)
    return {fault_of(
        "section.half_thickness", "", "is missing",
        "half the opening of the mould, one value or a table",
        "write the mould to begin with, a rectangle of the wanted half-thickness will do")};
  return {};
}

/// Faults of a case whose runs cannot show a steady face.
std::vector<v1::Fault> case_faults(const v1::Case& base) {
  auto faults = section_faults(base);

  if (!base.mesh().file().empty())
    faults.push_back(fault_of("mesh.file", base.mesh().file(),
                              "has a mould of its own that cannot be opened further",
                              "the built-in mesh", "leave mesh.file out"));

  if (base.mesh().has_growth() && !base.mesh().growth())
    faults.push_back(fault_of("mesh.growth", "false",
                              "is a block of fixed size: no casting becomes steady", "true",
                              "leave mesh.growth out"));

  if (base.mechanics().has_enabled() && !base.mechanics().enabled())
    faults.push_back(fault_of("mechanics.enabled", "false", "leaves the slab as wide as its mould",
                              "true", "leave mechanics.enabled out"));

  return faults;
}

/// The opening as a table of a case file.
std::string table_text(const MouldOpening& opening) {
  std::string text;
  for (std::size_t i = 0; i < opening.x.size(); ++i) {
    text += text.empty() ? "[[\"" : ", [\"";
    text += in_mm(opening.x[i]) + "\", \"" + in_mm(opening.half[i]) + "\"]";
  }
  return text + "]";
}

class MouldStudy final : public StudyPlan {
public:
  explicit MouldStudy(const v1::CreateStudyRequest& request)
      : base_(request.case_()), plan_(request.mould()), target_(target()) {}

  int runs() const override { return 1; }
  int most_runs() const override {
    return plan_.maximum_runs() == 0 ? usual_runs : plan_.maximum_runs();
  }
  bool needs_faces() const override { return true; }
  /// The first run uses the mould of the case.
  PlannedRun run(int number) const override {
    return planned(number, "run " + key(number), base_, {});
  }

  std::optional<PlannedRun> next(int number,
                                 const std::vector<EvaluatedRun>& before) const override {
    std::vector<frames::SteadyFace> history;
    for (const EvaluatedRun& evaluated : before)
      if (evaluated.face) history.push_back(evaluated.face->steady);
    const auto opening = next_opening(history, target_);
    if (!opening) return std::nullopt;
    return planned(number, "run " + key(number), base_, changes_to(*opening));
  }

  void evaluate(const std::vector<EvaluatedRun>& runs, v1::StudyResult& result) const override {
    std::vector<const RunFace*> faces;
    for (const EvaluatedRun& run : runs)
      if (run.face) faces.push_back(&*run.face);
    if (faces.empty()) return;

    // The best mould is that of the flattest slab.
    const auto residual = [this](const RunFace* face) {
      return face->steady.residual_m(target_.wanted);
    };
    const RunFace* best = *std::ranges::min_element(faces, {}, residual);

    v1::StudyResult::MouldFound& found = *result.mutable_mould();
    const v1::Curve& opening = best->section.half_thickness_m();
    *found.mutable_x_m() = opening.at();
    *found.mutable_half_opening_m() = opening.value();

    found.mutable_profile_x_m()->Assign(best->steady.x_m.begin(), best->steady.x_m.end());
    found.mutable_profile_m()->Assign(best->steady.cold_m.begin(), best->steady.cold_m.end());

    found.set_residual_m(residual(best));
    found.set_within_tolerance(found.residual_m() <= target_.tolerance);
    found.set_wanted_half_thickness_m(target_.wanted);
    found.set_is_steady(best->steady.change_m <= target_.tolerance);
  }

private:
  MouldTarget target() const {
    v1::Case complete = base_;
    case_file::apply_quality(complete);
    const double length = base_.section().half_width_m();
    const int columns = complete.mesh().has_columns() ? complete.mesh().columns() : columns_unknown;
    const double wanted = plan_.wanted_half_thickness_m() > 0.0
                              ? plan_.wanted_half_thickness_m()
                              : frames::half_opening_m(base_.section(), length);
    // Three segments must fit into the face whatever its columns.
    const double spacing =
        length * std::clamp(columns_per_segment / columns, shortest_segment, 0.3);
    return {wanted, plan_.tolerance_m(), {length, spacing, wanted, widest_opening * wanted}};
  }

  /// The opening, and with it the monitors that are on the face.
  std::vector<v1::CaseChange> changes_to(const MouldOpening& opening) const {
    std::vector<v1::CaseChange> changes{
        case_file::change_of("section.half_thickness", table_text(opening))};
    for (int i = 0; i < base_.monitor_size(); ++i) {
      const v1::Monitor& monitor = base_.monitor(i);
      if (!monitor.of().empty()) continue;
      const double before = frames::half_opening_m(base_.section(), monitor.x_m());
      const double now = opening.at(monitor.x_m());
      const bool on_face = monitor.y_m() >= std::min(now, before - on_the_face);
      if (!on_face && !in_corner(monitor)) continue;
      const double y = on_face ? now : monitor.y_m() + now - before;
      changes.push_back(case_file::change_of("monitor[" + std::to_string(i) + "].y", in_mm(y)));
    }
    return changes;
  }

  /// Near a rounded corner, which goes with the opening at the narrow face.
  bool in_corner(const v1::Monitor& monitor) const {
    const v1::Section& section = base_.section();
    return section.corner_radius_m() > 0.0 &&
           monitor.x_m() > section.half_width_m() - section.corner_radius_m() &&
           monitor.y_m() >
               frames::half_opening_m(section, section.half_width_m()) - section.corner_radius_m();
  }

  v1::Case base_;
  v1::MouldPlan plan_;
  MouldTarget target_;
};

}  // namespace

std::vector<v1::Fault> mould_faults(const v1::CreateStudyRequest& request) {
  auto faults = plan_value_faults(request.mould());
  const auto of_case = case_faults(request.case_());
  faults.insert(faults.end(), of_case.begin(), of_case.end());
  return faults;
}

std::unique_ptr<StudyPlan> mould_plan(const v1::CreateStudyRequest& request) {
  return std::make_unique<MouldStudy>(request);
}

}  // namespace dccast::studies
