// What measurements say of the data of a case (docs/calibration.md).
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "proto/case_file/study_keys.hpp"
#include "proto/values/printable.hpp"
#include "server/judging/study_parts.hpp"

namespace dccast::judging {
namespace {

using v1::Calibration;
using v1::JudgementPart;
using Values = google::protobuf::RepeatedField<double>;

// Of the width that a range had: below, a key is narrowed; above, it is as unknown as before.
constexpr double narrowed = 0.5;
constexpr double as_before = 0.85;

constexpr double not_separate = 0.6;  ///< correlation of keys that cannot be separated

/// A quantity that was measured, as sentences and tables name it.
struct Quantity {
  bool is_curl;
  const char* table;  ///< key of its table
  const char* name;   ///< "curl"
  const char* names;  ///< "curls"
  const char* unit;   ///< of differences, in SI
  const char* shown;  ///< the unit of the sentences
  double factor;      ///< from SI to that unit
  double resolution;  ///< [unit] of root mean squares
};

constexpr Quantity curls{true, "curls", "curl", "curls", "m", "mm", 1e3, 1e-4};
constexpr Quantity temperatures{false, "temperatures", "temperature", "temperatures", "K", "K", 1.0,
                                0.1};

const Quantity& quantity_of(const Calibration::Curve& curve) {
  return curve.measured().curl_m_size() > 0 ? curls : temperatures;
}

/// "0.30", in the unit of the sentences.
std::string shown(const Calibration::Curve& curve, double value, int decimals = 1) {
  return fmt::format("{:.{}f}", quantity_of(curve).factor * value, decimals);
}

std::vector<double> vector_of(const Values& values) {
  return {values.begin(), values.end()};
}

/// "a, b and c"
std::string enumerated(const std::vector<std::string>& names) {
  if (names.size() < 2) return joined(names, "");
  const std::vector<std::string> first(names.begin(), names.end() - 1);
  return fmt::format("{} and {}", joined(first, ", "), names.back());
}

/// "curl of corner", of a second casting with its number.
std::string curve_name(const Calibration& calibration, const Calibration::Curve& curve) {
  const std::string name =
      fmt::format("{} of {}", quantity_of(curve).name, curve.measured().monitor());
  if (calibration.runs_size() < 2) return name;
  return fmt::format("{}, casting {}", name, curve.casting() + 1);
}

/// The name of a file without its folder, short enough for a table.
std::string file_name(const std::string& path) {
  constexpr std::size_t longest = 24;
  return values::shortened(std::filesystem::path(path).filename().string(), longest);
}

void add_narrowed_keys(const v1::StudyResult& result, v1::Judgement& judgement) {
  const Calibration& calibration = result.calibration();
  const auto& axes = result.study().sweep().axes();
  std::vector<std::string> known;
  std::vector<std::string> unknown;
  for (int i = 0; i < calibration.keys_size(); ++i) {
    const std::string datum = case_file::datum_of(axes[i].key());
    if (calibration.keys(i).narrowed() <= narrowed) known.push_back(datum);
    if (calibration.keys(i).narrowed() >= as_before) unknown.push_back(datum);
  }

  if (!known.empty())
    judgement.add_sentences(fmt::format("The measurement narrows {}.", enumerated(known)));
  if (!unknown.empty())
    judgement.add_sentences(fmt::format("It does not narrow {}, whose {}.", enumerated(unknown),
                                        unknown.size() == 1 ? "range stays" : "ranges stay"));
}

void add_pairs_that_cannot_be_separated(const v1::StudyResult& result, v1::Judgement& judgement) {
  const Calibration& calibration = result.calibration();
  const auto& axes = result.study().sweep().axes();
  for (int i = 0; i < calibration.keys_size(); ++i)
    for (int j = 0; j < i; ++j) {
      const double correlation = calibration.keys(i).correlation(j);
      if (std::abs(correlation) < not_separate) continue;
      judgement.add_sentences(
          fmt::format("It cannot separate {} and {}: {} fits as well (correlation {:.2f}).",
                      case_file::datum_of(axes[j].key()), case_file::datum_of(axes[i].key()),
                      correlation < 0.0 ? "more of the one with less of the other" : "more of both",
                      correlation));
    }

  judgement.add_sentences(fmt::format("Of the {} free keys it fixes {} combination{}.",
                                      calibration.keys_size(), calibration.fixed(),
                                      calibration.fixed() == 1 ? "" : "s"));
}

/// States where the calibrated data follow a curve less well than the ranges did on the mean.
void add_worse_fits(const Calibration& calibration, v1::Judgement& judgement) {
  constexpr double noticeable = 1.05;
  for (const Calibration::Curve& curve : calibration.curves()) {
    if (curve.off_after() <= noticeable * curve.off_before()) continue;
    judgement.add_sentences(fmt::format(
        "The fit to the {} of {} became worse: {} off before, {} {} after. Other readings, or the "
        "ranges of the free keys, pull the other way.",
        quantity_of(curve).name, curve.measured().monitor(), shown(curve, curve.off_before(), 2),
        shown(curve, curve.off_after(), 2), quantity_of(curve).shown));
  }
}

std::string misfit_sentence(const Calibration::Curve& curve) {
  const Quantity& quantity = quantity_of(curve);
  const Calibration::Share& misfit = curve.misfit();
  if (misfit.low() <= std::max(curve.noise().median(), curve.surface_error()))
    return fmt::format("The model needs no misfit to follow the {}: it is less than {} {} (95 %).",
                       quantity.names, shown(curve, misfit.high(), 2), quantity.shown);
  return fmt::format(
      "Whatever its data, the model is off the {} by about {} {} ({} to {}): something is wrong or "
      "missing in it, and the ranges are wider for it.",
      quantity.names, shown(curve, misfit.median()), quantity.shown, shown(curve, misfit.low()),
      shown(curve, misfit.high()));
}

/// The misfit is inferred once for all curls and once for all temperatures.
void add_misfits(const Calibration& calibration, v1::Judgement& judgement) {
  for (const Quantity* quantity : {&curls, &temperatures}) {
    const auto first =
        std::ranges::find(calibration.curves(), quantity,
                          [](const Calibration::Curve& curve) { return &quantity_of(curve); });
    if (first != calibration.curves().end()) judgement.add_sentences(misfit_sentence(*first));
  }
}

void add_mesh_error(const Calibration& calibration, v1::Judgement& judgement) {
  judgement.add_sentences(
      calibration.has_mesh_error()
          ? fmt::format("Mesh and time steps leave ± {} % of a curl open; that is in the ranges.",
                        percent(calibration.mesh_error()))
          : "What mesh and time steps add is not known for such a case and not part of the ranges: "
            "run dccast convergence.");
}

/// The curve whose check is the worst in relation to the error of its surface; null: none has one.
const Calibration::Curve* worst_check(const Calibration& calibration) {
  const Calibration::Curve* worst = nullptr;
  for (const Calibration::Curve& curve : calibration.curves()) {
    if (!curve.has_check_error()) continue;
    if (worst == nullptr ||
        curve.check_error() * worst->checked_error() > worst->check_error() * curve.checked_error())
      worst = &curve;
  }
  return worst;
}

void add_check(const Calibration& calibration, v1::Judgement& judgement) {
  const Calibration::Curve* const worst = worst_check(calibration);
  if (worst == nullptr) {
    judgement.add_sentences("No run has checked this yet: it rests on the response surface alone.");
    return;
  }

  const char* const unit = quantity_of(*worst).shown;
  judgement.add_sentences(fmt::format(
      "Runs at the calibrated values and along the ridge are {} {} off the response surface before "
      "them, which has {} {} as its error: {}. They are part of it now.",
      shown(*worst, worst->check_error(), 2), unit, shown(*worst, worst->checked_error(), 2), unit,
      worst->is_confirmed() ? "it holds" : "it did not hold"));
}

/// The range that 9 of 10 draws lie in.
std::string range_after(const v1::SweepPlan::Axis& axis, const Calibration::Key& key) {
  v1::SweepPlan::Axis after;
  after.set_key(axis.key());
  after.add_values(case_file::rounded(key.low_text()));
  after.add_values(case_file::rounded(key.high_text()));
  return case_file::range_of(after);
}

void add_keys(const v1::StudyResult& result, v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, "keys", "the data after the measurement");
  add_columns(table, {
                         text_column("name", "free key"),
                         text_column("range_before", "range before"),
                         text_column("value", "value"),
                         text_column("range_after", "5 to 95 % after"),
                         number_column("width_left", "width left", "1", 0.01),
                         text_column("key", ""),
                     });

  for (int i = 0; i < result.calibration().keys_size(); ++i) {
    const v1::SweepPlan::Axis& axis = result.study().sweep().axes(i);
    const Calibration::Key& key = result.calibration().keys(i);
    add_row(table,
            {text_cell(case_file::datum_of(axis.key())), text_cell(case_file::range_of(axis)),
             text_cell(case_file::rounded(key.best_text())), text_cell(range_after(axis, key)),
             number_cell(key.narrowed()), text_cell(axis.key())});
  }
}

/// Median with the distances to 5 and 95 %; one value has none.
v1::Cell share_cell(const Calibration::Share& share) {
  v1::Cell cell = number_cell(share.median());
  if (share.low() == share.high()) return cell;

  cell.set_lower_error(share.median() - share.low());
  cell.set_upper_error(share.high() - share.median());
  return cell;
}

/// How the model follows what was measured of a quantity.
void add_curves(const Calibration& calibration, const Quantity& quantity,
                v1::Judgement& judgement) {
  const auto is_of = [&](const Calibration::Curve& curve) {
    return quantity_of(curve).is_curl == quantity.is_curl;
  };
  if (std::ranges::none_of(calibration.curves(), is_of)) return;

  v1::Table& table =
      add_table(judgement, quantity.table,
                fmt::format("how the model follows the {} that were measured", quantity.names));
  add_columns(table, {
                         text_column("measured", "measured"),
                         text_column("source", "in"),
                         text_column("readings", "readings"),
                     });
  const auto add_figure = [&](const char* key, const char* heading, double resolution) {
    add_columns(table, {number_column(key, heading, quantity.unit, resolution)});
  };
  add_figure("off_before", "before", quantity.resolution);
  add_figure("off_after", "after", quantity.resolution);
  for (const char* share : {"noise", "misfit"}) {
    add_figure(share, share, 0.1 * quantity.resolution);
    table.mutable_columns()->rbegin()->set_has_error(true);
  }
  add_figure("surface_error", "surface", 0.1 * quantity.resolution);
  table.set_note(
      "Before and after: root mean square of what the readings are off the curve; the others are "
      "standard deviations, ± to 5 and 95 % (docs/calibration.md).");

  for (const Calibration::Curve& curve : calibration.curves()) {
    if (!is_of(curve)) continue;
    const v1::MeasuredCurve& measured = curve.measured();
    add_row(
        table,
        {text_cell(curve_name(calibration, curve)), text_cell(file_name(measured.source())),
         text_cell(fmt::format("{} of {}", measured.time_s_size(), curve.readings())),
         number_cell(curve.off_before()), number_cell(curve.off_after()), share_cell(curve.noise()),
         share_cell(curve.misfit()), number_cell(curve.surface_error())});
  }
}

/// What was measured over what is computed, with the bands of the data before and after and, apart
/// from them, that of mesh and time steps.
void add_measured_chart(const Calibration& calibration, const Calibration::Curve& curve,
                        v1::Judgement& judgement) {
  const bool is_curl = quantity_of(curve).is_curl;
  const v1::MeasuredCurve& measured = curve.measured();
  v1::Chart& chart =
      add_chart(judgement, "measured",
                fmt::format("{}, measured and computed", curve_name(calibration, curve)),
                {"time", "s", quantity_of(curve).name, is_curl ? "m" : "degC"});
  add_line(chart, "measured", vector_of(measured.time_s()),
           vector_of(is_curl ? measured.curl_m() : measured.temperature_c()))
      .set_is_dotted(true);

  const std::vector<double> time_s = vector_of(curve.time_s());
  const auto add_data = [&](const char* name, const Calibration::Band& band) {
    v1::Chart::Line& line = add_line(chart, name, time_s, vector_of(band.median()));
    *line.mutable_low() = band.low();
    *line.mutable_high() = band.high();
  };
  add_data("data before, 5 to 95 %", curve.before());
  add_data("data after, 5 to 95 %", curve.after());

  if (!is_curl || !calibration.has_mesh_error()) return;
  v1::Chart::Line& mesh = add_line(chart, "mesh and time steps", time_s, vector_of(curve.best()));
  v1::RelativeError error;  // the calibration takes the larger side for both
  error.set_lower(calibration.mesh_error());
  error.set_upper(calibration.mesh_error());
  add_band(mesh, error);
  // The band alone: its middle is nearly that of the data after.
  for (double& value : *mesh.mutable_y()) value = std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

void judge_calibration(const v1::StudyResult& result, v1::Judgement& judgement) {
  if (!result.has_calibration()) {
    judgement.add_sentences(
        (is_under_way(result) ? "No answer yet: " : "The study has no answer: ") +
        result.calibration_fault());
    add_lost_runs(result, JudgementPart::ANYWHERE, judgement);
    return;
  }

  const Calibration& calibration = result.calibration();
  add_narrowed_keys(result, judgement);
  add_pairs_that_cannot_be_separated(result, judgement);
  add_worse_fits(calibration, judgement);
  add_misfits(calibration, judgement);
  add_mesh_error(calibration, judgement);
  add_check(calibration, judgement);

  for (const Calibration::Curve& curve : calibration.curves())
    add_measured_chart(calibration, curve, judgement);
  add_keys(result, judgement);
  for (const Quantity* quantity : {&curls, &temperatures})
    add_curves(calibration, *quantity, judgement);
  add_lost_runs(result, JudgementPart::ANYWHERE, judgement);
}

}  // namespace dccast::judging
