#pragma once

#include <span>
#include <string>
#include <variant>

#include "core/results/step_report.hpp"

namespace dccast::results {

/// A number of StepReport that is stored for every step: name in the file, unit and meaning. The
/// journal, the HDF5 writer and the reader all use this one table.
///
/// Units: a real value is in the unit of its field. What is per metre of face in a section is that
/// of the whole quarter in a quarter slab, and its name has no `_per_m` there.
struct HistoryField {
  const char* name;  ///< dataset below /history, of a section
  const char* unit;
  const char* meaning;
  std::variant<double StepReport::*, int StepReport::*, std::int64_t StepReport::*,
               bool StepReport::*>
      member;

  const char* solid_unit = nullptr;  ///< unit for a quarter slab, if different

  bool real() const { return member.index() == 0; }
  std::string name_in(int dimension) const;
  const char* unit_in(int dimension) const {
    return dimension == 3 && solid_unit != nullptr ? solid_unit : unit;
  }
};

/// All fields except the monitors, which are arrays, and except `solver_seconds` and
/// `process_seconds`: these depend on the computer, and two runs of a case would not give the same
/// file.
std::span<const HistoryField> history_fields();

/// The value of a real field [its unit]. @pre field.real()
double real_value(const HistoryField& field, const StepReport& report);
void set_real(const HistoryField& field, StepReport& report, double value);
/// The value of an integer field; 0 or 1 for a flag. @pre !field.real()
std::int64_t integer_value(const HistoryField& field, const StepReport& report);
void set_integer(const HistoryField& field, StepReport& report, std::int64_t value);

}  // namespace dccast::results
