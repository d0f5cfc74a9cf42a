// Which mould opening gives a flat cold slab (docs/contraction.md).
#include <fmt/core.h>

#include <algorithm>

#include "server/judging/study_parts.hpp"

namespace dccast::judging {
namespace {

using v1::JudgementPart;
using MouldFound = v1::StudyResult::MouldFound;
using Values = google::protobuf::RepeatedField<double>;

// Smallest differences that are shown [m]: of places along the face, and of moulds and slabs.
constexpr double shown_place_m = 1e-3;
constexpr double shown_thickness_m = 1e-5;
constexpr double shown_share = 1e-3;

std::string listed_mm(const Values& metres, int decimals) {
  return joined(metres, ", ", [&](double value) { return figures::mm(value, decimals); });
}

/// The run with the opening that was found; null: none has a face yet.
const v1::StudyRun* best_run(const v1::StudyResult& result) {
  const v1::StudyRun* best = nullptr;
  for (const v1::StudyRun& run : result.runs())
    if (run.has_face() && (best == nullptr || run.face().residual_m() < best->face().residual_m()))
      best = &run;
  return best;
}

/// "304.18 mm from the middle to 210 mm, 298.11 mm at 430 mm, 290.80 mm at 660 mm".
std::string opening_text(const MouldFound& found) {
  std::string text;
  bool is_flat = false;  // up to the next break point
  for (int i = 0; i < found.x_m_size(); ++i) {
    const bool was_flat = is_flat;
    is_flat = i + 1 < found.x_m_size() && found.half_opening_m(i + 1) == found.half_opening_m(i);
    if (is_flat) continue;

    text += fmt::format("{}{} mm {} {} mm", text.empty() ? "" : ", ",
                        figures::mm(found.half_opening_m(i), 2),
                        was_flat ? "from the middle to" : "at", figures::mm(found.x_m(i), 0));
  }
  return text;
}

/// How far the search came, and why it goes no further.
std::string end_text(const v1::StudyResult& result) {
  constexpr int usual_runs = 12;  // study.proto
  const v1::Study& study = result.study();
  const v1::MouldPlan& plan = study.mould();
  const std::string residual = figures::mm(result.mould().residual_m(), 2);
  const std::string tolerance = figures::mm(plan.tolerance_m(), 2);
  if (result.mould().within_tolerance())
    return fmt::format("flat within {} mm (tolerance {} mm)", residual, tolerance);
  if (study.state() != v1::STUDY_SUCCEEDED)
    return fmt::format("within {} mm of flat so far", residual);

  const int most = plan.maximum_runs() == 0 ? usual_runs : plan.maximum_runs();
  return fmt::format("within {} mm of flat, more than the tolerance of {} mm: {}", residual,
                     tolerance,
                     study.runs() >= most ? "these were all the runs permitted"
                                          : "three straight segments cannot come closer");
}

void add_sentences(const v1::StudyResult& result, const v1::StudyRun* best,
                   v1::Judgement& judgement) {
  if (best == nullptr) {
    judgement.add_sentences("No run has shown a cold slab yet.");
    return;
  }

  const MouldFound& found = result.mould();
  const auto succeeded = std::ranges::count(result.runs(), v1::SUCCEEDED, &v1::StudyRun::state);
  judgement.add_sentences(fmt::format(
      "A mould with half-openings of {} gives a cold slab of half-thickness {} mm, {}, after {} "
      "run{}.",
      opening_text(found), figures::mm(found.wanted_half_thickness_m(), 2), end_text(result),
      succeeded, succeeded == 1 ? "" : "s"));

  const v1::MouldFace& face = best->face();
  judgement.add_sentences(fmt::format(
      "Read {} mm above the block, around which the half-thickness changes by {} mm{}.",
      figures::mm(face.height_m(), 0), figures::mm(face.change_m(), 2),
      found.is_steady()
          ? ""
          : ", more than the tolerance: the face is not steady yet and may contract further, the "
            "opening is not to be used; cast longer (time.end)"));
}

/// Why the face of a run is not known; empty where it is, or the run has not ended.
std::string reason_of(const v1::StudyRun& run) {
  return run.has_failure() ? run.failure().message() : run.face_fault();
}

/// Every run with its mould and how far its slab is off.
void add_trials(const v1::StudyResult& result, v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, "trials", "");
  add_columns(table, {
                         number_column("run", "run", "", 1.0),
                         text_column("outcome", "outcome"),
                         text_column("break_points", "break points mm"),
                         text_column("half_openings", "half-openings mm"),
                         number_column("residual", "off flat", "m", shown_thickness_m),
                         number_column("height", "at", "m", shown_place_m),
                         text_column("job", "job"),
                         text_column("message", ""),
                     });

  std::vector<std::string> reasons;
  for (const v1::StudyRun& run : result.runs()) {
    const int number = table.rows_size() + 1;
    if (!reason_of(run).empty())
      reasons.push_back(fmt::format("run {}: {}", number, reason_of(run)));

    const v1::MouldFace& face = run.face();
    add_row(table, {number_cell(number), code_cell(outcome_code(run)),
                    text_cell(listed_mm(face.break_point_m(), 0)),
                    text_cell(listed_mm(face.half_opening_m(), 2)),
                    run.has_face() ? number_cell(face.residual_m()) : v1::Cell(),
                    run.has_face() ? number_cell(face.height_m()) : v1::Cell(),
                    text_cell(run.job()), text_cell(reason_of(run))});
  }
  table.set_note(joined(reasons, "; "));
}

void add_opening(const MouldFound& found, v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, "opening", "opening");
  add_columns(table, {
                         number_column("break_point", "break point", "m", shown_place_m),
                         number_column("half_opening", "half-opening", "m", shown_thickness_m),
                         number_column("opening", "opening", "m", shown_thickness_m),
                         number_column("over_wanted", "over wanted", "1", shown_share),
                     });

  const double wanted_m = found.wanted_half_thickness_m();
  for (int i = 0; i < found.x_m_size(); ++i) {
    const double half_m = found.half_opening_m(i);
    add_row(table, {number_cell(found.x_m(i)), number_cell(half_m), number_cell(2.0 * half_m),
                    number_cell((half_m - wanted_m) / wanted_m)});
  }
}

void add_cold_slab(const v1::MouldFace& face, double wanted_m, v1::Judgement& judgement) {
  v1::Table& table = add_table(judgement, "cold_slab", "predicted cold slab");
  add_columns(table, {
                         number_column("x", "x", "m", 0.1 * shown_place_m),
                         number_column("mould", "mould", "m", shown_thickness_m),
                         number_column("cold_slab", "cold slab", "m", shown_thickness_m),
                         number_column("over_wanted", "over wanted", "m", shown_thickness_m),
                         number_column("pull_in", "pull-in", "1", shown_share),
                     });

  for (int i = 0; i < face.x_m_size(); ++i) {
    const double mould_m = face.half_mould_m(i);
    const double cold_m = face.half_thickness_m(i);
    add_row(table, {number_cell(face.x_m(i)), number_cell(mould_m), number_cell(cold_m),
                    number_cell(cold_m - wanted_m), number_cell((mould_m - cold_m) / mould_m)});
  }
}

/// A line for each run, of the last ones where there are more than colours.
/// @param along  half a thickness by place along the face
v1::Chart* add_face_chart(const v1::StudyResult& result, const std::string& key,
                          const std::string& heading, const Values& (v1::MouldFace::*along)() const,
                          v1::Judgement& judgement) {
  std::vector<int> shown;
  for (int i = 0; i < result.runs_size(); ++i)
    if (result.runs(i).has_face()) shown.push_back(i);
  if (shown.empty()) return nullptr;
  if (std::ssize(shown) > most_lines) shown.erase(shown.begin(), shown.end() - most_lines);

  v1::Chart& chart =
      add_chart(judgement, key, heading,
                {"distance from the middle of the wide face", "m", "half-thickness", "m"});
  for (const int run : shown) {
    const v1::MouldFace& face = result.runs(run).face();
    v1::Chart::Line& line = *chart.add_lines();
    line.set_name(fmt::format("run {}", run + 1));
    *line.mutable_x() = face.x_m();
    *line.mutable_y() = (face.*along)();
  }
  return &chart;
}

void add_charts(const v1::StudyResult& result, v1::Judgement& judgement) {
  add_face_chart(result, "half_opening", "half-opening of the mould", &v1::MouldFace::half_mould_m,
                 judgement);
  v1::Chart* const slab =
      add_face_chart(result, "cold_slab", "cold slab", &v1::MouldFace::half_thickness_m, judgement);
  if (slab == nullptr) return;

  const double wanted_m = result.mould().wanted_half_thickness_m();
  const double tolerance_m = result.study().mould().tolerance_m();
  v1::Chart::Region& region = *slab->mutable_region();
  region.set_low(wanted_m - tolerance_m);
  region.set_high(wanted_m + tolerance_m);
  region.set_name("wanted");
}

}  // namespace

void judge_mould(const v1::StudyResult& result, v1::Judgement& judgement) {
  const v1::StudyRun* const best = best_run(result);
  add_sentences(result, best, judgement);
  add_charts(result, judgement);
  add_trials(result, judgement);
  if (best == nullptr) return;

  add_opening(result.mould(), judgement);
  add_cold_slab(best->face(), result.mould().wanted_half_thickness_m(), judgement);
}

}  // namespace dccast::judging
