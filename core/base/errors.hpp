#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace dccast {

/// One fault of a case, described for the person who wrote the case.
struct Fault {
  std::string field;      ///< path in the case file, e.g. "schedule.casting_speed"
  std::string value;      ///< the given value, as text; empty if there is none
  std::string message;    ///< what is wrong with the value
  std::string permitted;  ///< the permitted range, with its unit
  std::string remedy;     ///< what to write instead
};

/// Collects all faults of a case, so that one answer lists them. Values are in SI units and °C.
class Faults {
public:
  /// Adds a fault; the order is kept.
  void add(Fault fault) { list_.push_back(std::move(fault)); }
  /// @param value  [SI unit of the field, °C], written with six digits
  void add(std::string_view field, double value, std::string_view message,
           std::string_view permitted = {}, std::string_view remedy = {});
  /// @param field  path in the case file; the other texts as in Fault
  void add(std::string_view field, std::string_view value, std::string_view message,
           std::string_view permitted = {}, std::string_view remedy = {});

  bool empty() const { return list_.empty(); }
  const std::vector<Fault>& list() const { return list_; }  ///< in the order of add()
  /// All faults in one line: "field = value: message; ...".
  std::string summary() const;

private:
  std::vector<Fault> list_;
};

/// The case has faults that the user can correct. Its message is the summary of all faults.
class InvalidCase : public std::runtime_error {
public:
  explicit InvalidCase(Faults faults)
      : std::runtime_error(faults.summary()), faults_(std::move(faults)) {}
  /// All faults, in the order in which they were found.
  const std::vector<Fault>& faults() const { return faults_.list(); }

private:
  /// All faults that were found, never empty.
  Faults faults_;
};

/// A step did not converge at the smallest time step that the case permits.
class SolveFailed : public std::runtime_error {
public:
  /// @param message           what failed
  /// @param time              [s] beginning of the step
  /// @param time_step         [s] smallest step tried
  /// @param residual_history  [1] relative residual after each iteration of the last attempt
  SolveFailed(const std::string& message, double time, double time_step,
              std::vector<double> residual_history)
      : std::runtime_error(message),
        time_(time),
        time_step_(time_step),
        residual_history_(std::move(residual_history)) {}
  double time() const { return time_; }            ///< [s] beginning of the step
  double time_step() const { return time_step_; }  ///< [s] smallest step tried
  /// Relative residual after each iteration of the last attempt [1].
  const std::vector<double>& residual_history() const { return residual_history_; }

private:
  double time_;                           ///< [s]
  double time_step_;                      ///< [s]
  std::vector<double> residual_history_;  ///< [1] by iteration
};

}  // namespace dccast
