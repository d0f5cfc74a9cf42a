#include "client/text/data_study_text.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <fmt/core.h>

#include "client/model/study.hpp"
#include "client/session/data_study.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client::render {
namespace {

// Of the width that a range had: below, a key is narrowed; above, nothing is known of it.
constexpr double narrowed = 0.5, as_before = 0.85;
constexpr double not_separate = 0.6;  // correlation of keys that cannot be separated

std::string range_after(const v1::SweepPlan::Axis& axis, const v1::Calibration::Key& key) {
  v1::SweepPlan::Axis after;
  after.set_key(axis.key());
  after.add_values(rounded(key.low_text()));
  after.add_values(rounded(key.high_text()));
  return range_of(after);
}

std::string shown(const v1::Calibration::Curve& curve, double value, int decimals = 1) {
  return fixed(shown_units(curve) * value, decimals);
}

std::string interval(const v1::Calibration::Curve& curve, const v1::Calibration::Share& share) {
  const std::string median = shown(curve, share.median(), 2);
  if (share.low() == share.high()) return median;
  return fmt::format("{} ({} to {})", median, shown(curve, share.low(), 2),
                     shown(curve, share.high(), 2));
}

/// The name of a file without its folder, short enough for a table.
std::string file_of(const std::string& path) {
  constexpr std::size_t longest = 24;
  return values::shortened(std::filesystem::path(path).filename().string(), longest);
}

/// "a, b and c"
std::string enumerated(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

void add_keys(const v1::StudyResult& result, std::vector<std::string>& sentences) {
  const v1::Calibration& calibration = result.calibration();
  const auto& axes = result.study().sweep().axes();
  std::vector<std::string> known, unknown;
  for (int i = 0; i < calibration.keys_size(); ++i) {
    if (calibration.keys(i).narrowed() <= narrowed) known.push_back(datum_of(axes[i].key()));
    if (calibration.keys(i).narrowed() >= as_before) unknown.push_back(datum_of(axes[i].key()));
  }
  if (!known.empty()) sentences.push_back("The measurement narrows " + enumerated(known) + ".");
  if (!unknown.empty())
    sentences.push_back("It does not narrow " + enumerated(unknown) +
                        (unknown.size() == 1 ? ", whose range stays." : ", whose ranges stay."));
  for (int i = 0; i < calibration.keys_size(); ++i)
    for (int j = 0; j < i; ++j) {
      const double correlation = calibration.keys(i).correlation(j);
      if (std::abs(correlation) < not_separate) continue;
      sentences.push_back(
          fmt::format("It cannot separate {} and {}: {} fits as well (correlation {}).",
                      datum_of(axes[j].key()), datum_of(axes[i].key()),
                      correlation < 0.0 ? "more of the one with less of the other" : "more of both",
                      fixed(correlation, 2)));
    }
  sentences.push_back(fmt::format("Of the {} free keys it fixes {} combination{}.",
                                  calibration.keys_size(), calibration.fixed(),
                                  calibration.fixed() == 1 ? "" : "s"));
}

void add_misfits(const v1::Calibration& calibration, std::vector<std::string>& sentences) {
  bool curl = false, temperature = false;
  for (const auto& curve : calibration.curves()) {
    const bool of_curl = curve.measured().curl_m_size() > 0;
    bool& stated = of_curl ? curl : temperature;
    if (std::exchange(stated, true)) continue;
    const std::string what = of_curl ? "curls" : "temperatures";
    const std::string unit = of_curl ? " mm" : " K";
    const bool wrong =
        curve.misfit().low() > std::max(curve.noise().median(), curve.surface_error());
    sentences.push_back(
        wrong ? fmt::format("Whatever its data, the model is off the {} by about {}{} ({} to {}): "
                            "something is wrong or missing in it, and the ranges are wider for it.",
                            what, shown(curve, curve.misfit().median()), unit,
                            shown(curve, curve.misfit().low()), shown(curve, curve.misfit().high()))
              : fmt::format(
                    "The model needs no misfit to follow the {}: it is less than {}{} (95 %).",
                    what, shown(curve, curve.misfit().high(), 2), unit));
  }
}

/// Says where the calibrated data follow a curve less well than the ranges did on the mean.
void add_worse_fits(const v1::Calibration& calibration, std::vector<std::string>& sentences) {
  constexpr double noticeable = 1.05;
  for (const auto& curve : calibration.curves()) {
    if (curve.off_after() <= noticeable * curve.off_before()) continue;
    const bool of_curl = curve.measured().curl_m_size() > 0;
    sentences.push_back(fmt::format(
        "The fit to the {} of {} became worse: {} off before, {} {} after. Other readings, or the "
        "ranges of the free keys, pull the other way.",
        of_curl ? "curl" : "temperature", curve.measured().monitor(),
        shown(curve, curve.off_before(), 2), shown(curve, curve.off_after(), 2),
        of_curl ? "mm" : "K"));
  }
}

void add_mesh(const v1::Calibration& calibration, std::vector<std::string>& sentences) {
  if (!calibration.has_mesh_error()) {
    sentences.push_back(
        "What mesh and time steps add is not known for such a case and not part of the ranges: run "
        "dccast convergence.");
    return;
  }
  sentences.push_back("Mesh and time steps leave ± " + fixed(100.0 * calibration.mesh_error(), 0) +
                      " % of a curl open; that is in the ranges.");
}

void add_check(const v1::Calibration& calibration, std::vector<std::string>& sentences) {
  const v1::Calibration::Curve* worst = nullptr;
  for (const auto& curve : calibration.curves())
    if (curve.has_check_error() &&
        (worst == nullptr || curve.check_error() * worst->checked_error() >
                                 worst->check_error() * curve.checked_error()))
      worst = &curve;
  if (worst == nullptr) {
    sentences.push_back("No run has checked this yet: it rests on the response surface alone.");
    return;
  }
  const std::string unit = worst->measured().curl_m_size() > 0 ? " mm" : " K";
  sentences.push_back(fmt::format(
      "Runs at the calibrated values and along the ridge are {}{} off the response surface before "
      "them, which has {}{} as its error: {}. They are part of it now.",
      shown(*worst, worst->check_error(), 2), unit, shown(*worst, worst->checked_error(), 2), unit,
      is_confirmed(*worst) ? "it holds" : "it did not hold"));
}

}  // namespace

double shown_units(const v1::Calibration::Curve& curve) {
  return curve.measured().curl_m_size() > 0 ? 1e3 : 1.0;
}

std::string curve_name(const v1::Calibration& calibration, const v1::Calibration::Curve& curve) {
  const bool curl = curve.measured().curl_m_size() > 0;
  std::string name = (curl ? "curl of " : "temperature of ") + curve.measured().monitor();
  if (calibration.runs_size() > 1) name += ", casting " + std::to_string(curve.casting() + 1);
  return name + (curl ? ", mm" : ", K");
}

Rows key_rows(const v1::StudyResult& result) {
  Rows rows;
  for (int i = 0; i < result.calibration().keys_size(); ++i) {
    const auto& axis = result.study().sweep().axes(i);
    const auto& key = result.calibration().keys(i);
    rows.push_back({datum_of(axis.key()), range_of(axis), rounded(key.best_text()),
                    range_after(axis, key), fixed(100.0 * key.narrowed(), 0) + " %"});
  }
  return rows;
}

Rows curve_rows(const v1::Calibration& calibration) {
  Rows rows;
  for (const auto& curve : calibration.curves())
    rows.push_back(
        {curve_name(calibration, curve), file_of(curve.measured().source()),
         std::to_string(curve.measured().time_s_size()) + " of " + std::to_string(curve.readings()),
         shown(curve, curve.off_before()), shown(curve, curve.off_after()),
         interval(curve, curve.noise()), interval(curve, curve.misfit()),
         shown(curve, curve.surface_error(), 2)});
  return rows;
}

std::vector<std::string> calibration_sentences(const v1::StudyResult& result) {
  if (!result.has_calibration()) return {"No answer yet: " + result.calibration_fault()};
  std::vector<std::string> sentences;
  add_keys(result, sentences);
  add_worse_fits(result.calibration(), sentences);
  add_misfits(result.calibration(), sentences);
  add_mesh(result.calibration(), sentences);
  add_check(result.calibration(), sentences);
  return sentences;
}

std::string calibration_text(const v1::StudyResult& result) {
  std::string text = head_of(result);
  if (result.has_calibration())
    text += "\n" +
            Table({"free key", "range before", ">value", "5 to 95 % after", ">width left"},
                  key_rows(result))
                .text() +
            "\n" +
            Table({"measured", "in", ">readings used", ">off before", ">after", ">noise", ">misfit",
                   ">surface"},
                  curve_rows(result.calibration()))
                .text();
  return text + "\n" + paragraphs(calibration_sentences(result));
}

}  // namespace dccast::client::render
