#include "client/text/mould_text.hpp"

#include "client/text/job_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

constexpr int usual_runs = 12;  // study.proto

std::string mm(double metres, int decimals = 2) {
  return fixed(1e3 * metres, decimals);
}

template <class Values>
std::string listed(const Values& metres, int decimals) {
  std::string text;
  for (const double value : metres) text += (text.empty() ? "" : ", ") + mm(value, decimals);
  return text;
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
    words += (words.empty() ? "" : ", ") + mm(found.half_opening_m(i)) +
             (was_flat ? " mm from the middle to " : " mm at ") + mm(found.x_m(i), 0) + " mm";
  }
  return words;
}

/// How far the search came, and why it goes no further.
std::string end_words(const MouldDesign& design) {
  const v1::Study& study = design.result.study();
  const auto& found = design.found();
  const std::string near = mm(found.residual_m()) + " mm";
  if (found.within_tolerance())
    return "flat within " + near + " (tolerance " + mm(study.mould().tolerance_m()) + " mm)";
  if (study.state() != v1::STUDY_SUCCEEDED) return "within " + near + " of flat so far";
  const int most = study.mould().maximum_runs() == 0 ? usual_runs : study.mould().maximum_runs();
  return "within " + near + " of flat, more than the tolerance of " +
         mm(study.mould().tolerance_m()) + " mm: " +
         (study.runs() >= most ? "these were all the runs permitted"
                               : "three straight segments cannot come closer");
}

std::string steady_words(const MouldDesign& design, const frames::SteadyFace& face) {
  std::string words = "Read " + mm(face.height_m, 0) +
                      " mm above the block, around which the half-thickness changes by " +
                      mm(face.change_m) + " mm";
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
      row[4] = mm(run.cast->face.residual_m(design.wanted_m));
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
    table.add({mm(found.x_m(i), 0), mm(found.half_opening_m(i)), mm(2.0 * found.half_opening_m(i)),
               percent(found.half_opening_m(i) - design.wanted_m, design.wanted_m)});
  return table.text();
}

std::string mould_profile_table(const MouldDesign& design) {
  const MouldRun* best = design.best();
  if (best == nullptr) return {};
  const frames::SteadyFace& face = best->cast->face;
  Table table({">x mm", ">mould mm", ">cold slab mm", ">over wanted mm", ">pull-in"});
  for (std::size_t i = 0; i < face.x_m.size(); ++i)
    table.add({mm(face.x_m[i], 1), mm(face.mould_m[i]), mm(face.cold_m[i]),
               mm(face.cold_m[i] - design.wanted_m),
               percent(face.mould_m[i] - face.cold_m[i], face.mould_m[i])});
  return table.text();
}

std::string mould_sentence(const MouldDesign& design) {
  const MouldRun* best = design.best();
  if (best == nullptr) return "No run has shown a cold slab yet.\n";
  int succeeded = 0;
  for (const MouldRun& run : design.runs) succeeded += run.state == v1::SUCCEEDED ? 1 : 0;
  return "A mould with half-openings of " + opening_words(design.found()) +
         " gives a cold slab of half-thickness " + mm(design.wanted_m) + " mm, " +
         end_words(design) + ", after " + std::to_string(succeeded) +
         (succeeded == 1 ? " run.\n" : " runs.\n") + steady_words(design, best->cast->face);
}

std::string mould_text(const MouldDesign& design) {
  std::string text = "study " + design.result.study().id() + "\n" + mould_runs_table(design);
  if (design.best() != nullptr)
    text += "\nopening\n" + mould_opening_table(design) + "\npredicted cold slab\n" +
            mould_profile_table(design);
  return text + "\n" + mould_sentence(design);
}

}  // namespace dccast::client::render
