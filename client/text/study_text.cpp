#include "client/text/study_text.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <ostream>

#include <fmt/core.h>

#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal_guard.hpp"
#include "proto/case_file/key_place.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast::client::render {
namespace {

/// A figure, with a mark if it is beyond validity.
std::string marked(std::string figure, bool valid) {
  return valid ? figure : figure + " !";
}

/// ", about 3 min left" at the pace so far; empty before there is one and after the end.
std::string left_text(const v1::Study& study) {
  constexpr double least_progress = 0.02;
  if (study.state() != v1::STUDY_RUNNING || study.progress() < least_progress) return {};
  const double passed = static_cast<double>(std::time(nullptr) - study.create_time().seconds());
  return ", about " + duration_text(passed * (1.0 - study.progress()) / study.progress()) + " left";
}

/// Curl at the end of a level; "-" where it has none.
std::string end_curl(const StudyLevel& level, std::size_t monitor) {
  if (!level.succeeded() || monitor >= level.end_curl_m.size()) return "-";
  return marked(mm(level.end_curl_m[monitor], 3), !level.ends_beyond_validity());
}

}  // namespace

std::string state_text(v1::StudyState state) {
  switch (state) {
    case v1::STUDY_RUNNING:
      return "running";
    case v1::STUDY_SUCCEEDED:
      return "succeeded";
    case v1::STUDY_FAILED:
      return "failed";
    case v1::STUDY_CANCELLED:
      return "cancelled";
    default:
      return "unknown";
  }
}

std::string plan_text(const v1::Study& study) {
  if (study.has_refinement()) return "refinement";
  if (study.has_mould()) return "mould";
  if (study.has_recipe())
    return "recipe, " + std::to_string(study.recipe().numbers_size()) + " numbers";
  const std::string count = std::to_string(study.sweep().axes_size());
  if (study.sweep().purpose() == v1::SweepPlan::UNCERTAINTY)
    return "uncertainty, " + count + " data";
  if (study.sweep().purpose() == v1::SweepPlan::SENSITIVITY)
    return "sensitivity, " + count + " keys";
  if (study.sweep().purpose() == v1::SweepPlan::CALIBRATION)
    return study.sweep().further_of().empty()
               ? "calibration, " + count + " keys"
               : "further runs of calibration " + study.sweep().further_of();
  return "sweep of " + joined(study.sweep().axes(), ", ", &v1::SweepPlan::Axis::key);
}

std::string progress_text(const v1::Study& study) {
  const int ended = study.succeeded() + study.failed() + study.cancelled();
  std::string text = fmt::format("{} of {} runs", ended, study.runs());
  const auto add = [&text](int count, const char* what) {
    if (count > 0) text += fmt::format(", {} {}", count, what);
  };
  add(study.running(), "running");
  add(study.failed(), "failed");
  add(study.cancelled(), "cancelled");
  return text + ", " + fixed(100.0 * study.progress(), 0) + " %";
}

std::string study_sheet(const v1::Study& study) {
  std::string text = sheet_line("study", study.id()) + sheet_line("title", study.title()) +
                     sheet_line("plan", plan_text(study)) +
                     sheet_line("state", state_text(study.state())) +
                     sheet_line("runs", progress_text(study)) +
                     sheet_line("created", time_text(study.create_time()));
  if (study.has_end_time()) text += sheet_line("ended", time_text(study.end_time()));
  if (!study.owner().empty()) text += sheet_line("owner", study.owner());
  if (!study.labels().empty()) text += sheet_line("labels", joined(study.labels()));
  if (!study.message().empty()) text += sheet_line("message", study.message());
  return text;
}

StudyProgress::~StudyProgress() {
  if (line_open_) stream_ << std::endl;
}

void StudyProgress::show(const v1::Study& study) {
  if (terminal_.interactive) {
    stream_ << begin_of_line
            << cut_to(progress_text(study) + left_text(study), terminal_.columns - 1)
            << clear_rest_of_line << std::flush;
    line_open_ = true;
    return;
  }
  const int tenth = static_cast<int>(10.0 * study.progress());
  if (tenth <= shown_tenth_ && study.state() == v1::STUDY_RUNNING) return;
  shown_tenth_ = tenth;
  stream_ << progress_text(study) << left_text(study) << std::endl;
}

std::vector<std::string> monitor_names(const Study& study) {
  return study.succeeded().empty() ? std::vector<std::string>{} : study.monitor_names;
}

Rows level_rows(const Study& study) {
  Rows rows;
  for (const StudyLevel& level : study.levels) {
    const v1::StepReport& last = level.job.last_step();
    auto& row = rows.emplace_back();
    row = {std::to_string(level.refinement), std::to_string(last.nodes()),
           fixed(last.solver_s(), 1), full_state_text(level.job)};
    for (std::size_t k = 0; k < monitor_names(study).size(); ++k) row.push_back(end_curl(level, k));
  }
  return rows;
}

Rows limit_rows(const Study& study) {
  Rows rows{{"order", "", "", ""},
            {"limit", "", "", ""},
            {"+-", "", "", ""},
            {"+- at most", "", "", ""},
            {"at s", "", "", ""}};
  for (const MonitorStudy& monitor : study.monitors) {
    const CurveLimit& limit = monitor.limit;
    const std::size_t worst = monitor.least_certain();
    rows[0].push_back(limit.order ? fixed(*limit.order, 2) : "none");
    const bool valid = study.valid_at(study.time_s.back());
    rows[1].push_back(marked(mm(limit.value_m.back(), 3), valid));
    rows[2].push_back(marked(mm(limit.uncertainty_m.back(), 3), valid));
    rows[3].push_back(
        marked(mm(limit.uncertainty_m[worst], 3), study.valid_at(study.time_s[worst])));
    rows[4].push_back(fixed(study.time_s[worst], 2));
  }
  return study.monitors.empty() ? Rows{} : rows;
}

std::string validity_note(const Study& study) {
  if (!study.valid_until_s) return {};
  return std::string("! ") + beyond_validity + ": from " + fixed(*study.valid_until_s, 2) +
         " s on the model of at least one level is not valid";
}

std::string study_table(const Study& study) {
  std::vector<std::string> headings{">refinement", ">nodes", ">solver s", "state"};
  for (const std::string& name : monitor_names(study)) headings.push_back(">" + name + " mm");
  Table table(headings, level_rows(study));
  for (auto& row : limit_rows(study)) table.add(std::move(row));
  const std::string note = validity_note(study);
  return table.text() + (note.empty() ? note : note + "\n");
}

namespace {

/// "_m_per_s": the unit in which the numbers of a key are; "_factor" and "_si" have none of their
/// own.
std::string si_suffix(const std::string& key) {
  if (key.ends_with(".scale")) return "_factor";
  const auto* const field = case_file::field_at(v1::Case(), key);
  const auto suffix =
      field == nullptr ? std::nullopt : case_file::unit_suffix(case_file::key_of(*field).unit());
  return suffix && !suffix->empty() ? *suffix : "_si";
}

std::string csv_number(double value) {
  return std::isfinite(value) ? case_file::number_text(value) : "";
}

std::string csv_head(const v1::StudyResult& result) {
  std::string head = "run,job,state";
  for (const auto& axis : result.study().sweep().axes())
    head += "," + csv_text(axis.key()) + "," + csv_text(axis.key() + si_suffix(axis.key()));
  for (const std::string& monitor : result.monitors())
    head += "," + csv_text(monitor + "_end_curl_m") + "," + csv_text(monitor + "_uncertainty_m");
  return head + ",solver_s,beyond_validity,findings,failure\n";
}

/// What mesh and time steps leave uncertain of a curl of the run; NaN: not known.
double mesh_error_m(const v1::StudyRun& run, double curl_m) {
  return run.has_relative_curl_error() ? run.relative_curl_error() * std::abs(curl_m)
                                       : std::numeric_limits<double>::quiet_NaN();
}

std::string csv_row(const v1::StudyRun& run, int number) {
  std::string row = fmt::format("{},{},{}", number, run.job(), v1::JobState_Name(run.state()));
  for (int i = 0; i < run.values_size(); ++i)
    row += "," + csv_text(run.values(i)) + "," + csv_number(run.numbers(i));
  for (const double curl : run.end_curl_m())
    row += "," + csv_number(curl) + "," + csv_number(mesh_error_m(run, curl));
  return row + fmt::format(",{},{:d},{},{}\n", csv_number(run.solver_s()), run.beyond_validity(),
                           joined(run.findings(), " ", &v1::Finding::code),
                           csv_text(run.failure().message()));
}

}  // namespace

std::string run_text(const v1::StudyRun& run) {
  std::string text =
      run.job().empty() && run.state() == v1::QUEUED ? "waiting" : state_text(run.state());
  if (run.has_failure()) text += ": " + failure_kind_text(run.failure().kind());
  if (run.beyond_validity()) text += std::string(", ") + beyond_validity;
  const auto findings = std::ranges::count_if(run.findings(), [](const v1::Finding& finding) {
    return finding.severity() > v1::Finding::NOTE;
  });
  if (findings > 0) text += fmt::format(", {} finding{}", findings, findings == 1 ? "" : "s");
  return text;
}

std::string sweep_table(const v1::StudyResult& result) {
  std::vector<std::string> headings{">run"};
  for (const auto& axis : result.study().sweep().axes()) headings.push_back(">" + axis.key());
  const bool has_errors =
      std::ranges::any_of(result.runs(), &v1::StudyRun::has_relative_curl_error);
  for (const std::string& monitor : result.monitors()) {
    headings.push_back(">" + monitor + " mm");
    if (has_errors) headings.push_back(">\u00b1 mm");
  }
  headings.push_back("state");
  Table table(headings);
  for (int i = 0; i < result.runs_size(); ++i) {
    const v1::StudyRun& run = result.runs(i);
    std::vector<std::string> row{std::to_string(i + 1)};
    for (const std::string& value : run.values()) row.push_back(value);
    for (const double curl : run.end_curl_m()) {
      const double error_m = mesh_error_m(run, curl);
      const int decimals = mm_decimals(curl, error_m);
      row.push_back(mm(curl, decimals));
      if (has_errors) row.push_back(mm(error_m, decimals));
    }
    row.push_back(run_text(run));
    table.add(std::move(row));
  }
  return table.text();
}

std::string sweep_csv(const v1::StudyResult& result) {
  std::string text = csv_head(result);
  for (int i = 0; i < result.runs_size(); ++i) text += csv_row(result.runs(i), i + 1);
  return text;
}

namespace {

constexpr int usual_runs = 12;  // study.proto

template <class Values>
std::string listed(const Values& metres, int decimals) {
  return joined(metres, ", ", [&](double value) { return mm(value, decimals); });
}

std::string percent(double part, double whole) {
  return fixed(100.0 * part / whole, 1) + " %";
}

/// "304.18 mm from the middle to 210 mm, 298.11 mm at 430 mm, 290.80 mm at 660 mm".
std::string opening_words(const v1::StudyResult::MouldFound& found) {
  std::string words;
  bool flat = false;  // up to the next break point
  for (int i = 0; i < found.x_m_size(); ++i) {
    const bool was_flat = flat;
    flat = i + 1 < found.x_m_size() && found.half_opening_m(i + 1) == found.half_opening_m(i);
    if (flat) continue;
    words += (words.empty() ? "" : ", ") + mm(found.half_opening_m(i), 2) +
             (was_flat ? " mm from the middle to " : " mm at ") + mm(found.x_m(i), 0) + " mm";
  }
  return words;
}

/// How far the search came, and why it goes no further.
std::string end_words(const MouldDesign& design) {
  const v1::Study& study = design.result.study();
  const v1::MouldPlan& plan = study.mould();
  const std::string near = mm(design.found().residual_m(), 2),
                    tolerance = mm(plan.tolerance_m(), 2);
  if (design.found().within_tolerance())
    return fmt::format("flat within {} mm (tolerance {} mm)", near, tolerance);
  if (study.state() != v1::STUDY_SUCCEEDED) return fmt::format("within {} mm of flat so far", near);
  const int most = plan.maximum_runs() == 0 ? usual_runs : plan.maximum_runs();
  return fmt::format("within {} mm of flat, more than the tolerance of {} mm: {}", near, tolerance,
                     study.runs() >= most ? "these were all the runs permitted"
                                          : "three straight segments cannot come closer");
}

std::string steady_words(const MouldDesign& design, const frames::SteadyFace& face) {
  std::string words = "Read " + mm(face.height_m, 0) +
                      " mm above the block, around which the half-thickness changes by " +
                      mm(face.change_m, 2) + " mm";
  if (!design.steady())
    words +=
        ", more than the tolerance: the face is not steady yet and may contract further, the "
        "opening is not to be used; cast longer (time.end)";
  return words + ".\n";
}

}  // namespace

std::string mould_runs_table(const MouldDesign& design) {
  Table table(
      {">run", "state", ">break points mm", ">half-openings mm", ">off flat mm", ">at mm", "job"});
  int number = 0;
  for (const MouldRun& run : design.runs) {
    std::vector<std::string> row{
        std::to_string(++number), state_text(run.state), "", "", "", "", run.job};
    if (run.cast) {
      const v1::Curve& opening = run.cast->section.half_thickness_m();
      row[2] = listed(opening.at(), 0);
      row[3] = listed(opening.value(), 2);
      row[4] = mm(run.cast->face.residual_m(design.wanted_m), 2);
      row[5] = mm(run.cast->face.height_m, 0);
    }
    table.add(std::move(row));
  }
  std::string text = table.text();
  number = 0;
  for (const MouldRun& run : design.runs) {
    ++number;
    if (!run.reason.empty()) text += "run " + std::to_string(number) + ": " + run.reason + "\n";
  }
  return text;
}

std::string mould_opening_table(const MouldDesign& design) {
  const auto& found = design.found();
  if (found.x_m().empty()) return {};
  Table table({">break point mm", ">half-opening mm", ">opening mm", ">over wanted"});
  for (int i = 0; i < found.x_m_size(); ++i)
    table.add({mm(found.x_m(i), 0), mm(found.half_opening_m(i), 2),
               mm(2.0 * found.half_opening_m(i), 2),
               percent(found.half_opening_m(i) - design.wanted_m, design.wanted_m)});
  return table.text();
}

std::string mould_profile_table(const MouldDesign& design) {
  const MouldRun* best = design.best();
  if (best == nullptr) return {};
  const frames::SteadyFace& face = best->cast->face;
  Table table({">x mm", ">mould mm", ">cold slab mm", ">over wanted mm", ">pull-in"});
  for (std::size_t i = 0; i < face.x_m.size(); ++i)
    table.add({mm(face.x_m[i], 1), mm(face.mould_m[i], 2), mm(face.cold_m[i], 2),
               mm(face.cold_m[i] - design.wanted_m, 2),
               percent(face.mould_m[i] - face.cold_m[i], face.mould_m[i])});
  return table.text();
}

std::string mould_sentence(const MouldDesign& design) {
  const MouldRun* best = design.best();
  if (best == nullptr) return "No run has shown a cold slab yet.\n";
  const auto succeeded = std::ranges::count(design.runs, v1::SUCCEEDED, &MouldRun::state);
  return fmt::format(
             "A mould with half-openings of {} gives a cold slab of half-thickness {} mm, {}, "
             "after {} run{}.\n",
             opening_words(design.found()), mm(design.wanted_m, 2), end_words(design), succeeded,
             succeeded == 1 ? "" : "s") +
         steady_words(design, best->cast->face);
}

std::string mould_text(const MouldDesign& design) {
  std::string text = "study " + design.result.study().id() + "\n" + mould_runs_table(design);
  if (design.best() != nullptr)
    text += "\nopening\n" + mould_opening_table(design) + "\npredicted cold slab\n" +
            mould_profile_table(design);
  return text + "\n" + mould_sentence(design);
}

}  // namespace dccast::client::render
