#pragma once

#include <span>
#include <variant>

#include "core/results/step_report.hpp"

namespace dccast::results {

/// A number of StepReport that is stored at every step: its name in the file, its unit and meaning.
/// The journal, the HDF5 writer and the reader all go by this one table.
struct HistoryField {
  const char* name;  ///< dataset below /history
  const char* unit;
  const char* meaning;
  std::variant<double StepReport::*, int StepReport::*, std::int64_t StepReport::*,
               bool StepReport::*>
      member;

  const char* solid_unit = nullptr;  ///< of a quarter slab, where it is another one

  bool real() const { return member.index() == 0; }
  const char* unit_in(int dimension) const {
    return dimension == 3 && solid_unit != nullptr ? solid_unit : unit;
  }
};

/// All fields but the monitors, which are arrays, and `solver_seconds` and `process_seconds`, which
/// measure the computer: with them no two runs of a case would give the same file.
std::span<const HistoryField> history_fields();

/// The value of a real field, in its unit. @pre field.real()
double real_value(const HistoryField& field, const StepReport& report);
void set_real(const HistoryField& field, StepReport& report, double value);
/// The value of an integer field, 0 or 1 of a flag. @pre !field.real()
std::int64_t integer_value(const HistoryField& field, const StepReport& report);
void set_integer(const HistoryField& field, StepReport& report, std::int64_t value);

}  // namespace dccast::results
