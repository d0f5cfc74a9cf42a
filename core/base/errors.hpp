#pragma once

#include <cstdio>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace dccast {

/// One fault of a case, for the person who wrote the case.
struct Fault {
  std::string field;      ///< path in the case file, e.g. "schedule.casting_speed"
  std::string value;      ///< the value that was given
  std::string message;    ///< what is wrong with it
  std::string permitted;  ///< the permitted range, with its unit
  std::string remedy;     ///< what to write instead
};

/// Collects every fault of a case, so that one answer names them all. Values are in SI and °C.
class Faults {
public:
  void add(Fault fault) { list_.push_back(std::move(fault)); }
  /// @param value  [SI unit of the field, °C]
  void add(std::string_view field, double value, std::string_view message,
           std::string_view permitted = {}, std::string_view remedy = {}) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    add(field, text, message, permitted, remedy);
  }
  void add(std::string_view field, std::string_view value, std::string_view message,
           std::string_view permitted = {}, std::string_view remedy = {}) {
    list_.push_back({std::string(field), std::string(value), std::string(message),
                     std::string(permitted), std::string(remedy)});
  }
  bool empty() const { return list_.empty(); }
  const std::vector<Fault>& list() const { return list_; }
  /// All of them in one line.
  std::string summary() const {
    std::string text;
    for (const Fault& fault : list_) {
      if (!text.empty()) text += "; ";
      text += fault.field + " = " + fault.value + ": " + fault.message;
    }
    return text;
  }

private:
  std::vector<Fault> list_;
};

/// The case has faults that the user can correct; contains all of them.
class InvalidCase : public std::runtime_error {
public:
  explicit InvalidCase(Faults faults)
      : std::runtime_error(faults.summary()), faults_(std::move(faults)) {}
  const std::vector<Fault>& faults() const { return faults_.list(); }

private:
  Faults faults_;
};

/// A step did not converge at the smallest time step [s] that the case permits.
class SolveFailed : public std::runtime_error {
public:
  /// @param time [s] @param time_step [s] @param residual_history [1]
  SolveFailed(const std::string& what, double time, double time_step,
              std::vector<double> residual_history)
      : std::runtime_error(what),
        time_(time),
        time_step_(time_step),
        residual_history_(std::move(residual_history)) {}
  double time() const { return time_; }            ///< [s] where the step began
  double time_step() const { return time_step_; }  ///< [s] smallest step tried
  /// Relative residual after each iteration of the last attempt [1].
  const std::vector<double>& residual_history() const { return residual_history_; }

private:
  double time_;                           ///< [s]
  double time_step_;                      ///< [s]
  std::vector<double> residual_history_;  ///< [1] by iteration
};

}  // namespace dccast
