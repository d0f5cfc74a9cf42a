#pragma once

#include <functional>
#include <span>
#include <string>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/study.pb.h"

/// Keys that studies move, as plans name them and people read them.
namespace dccast::case_file {

/// A lever of a plant with the range in which sensitivity moves it: a tenth, or what a plant
/// changes between two castings.
struct Lever {
  /// Key of the lever, and how far `sensitivity` moves it.
  const char* key;
  const char* range;
  bool (*is_there)(const v1::Case&) = nullptr;  ///< in this case; null: in every one
};
/// All levers of a plant, in the order of docs/uncertainty.md.
std::span<const Lever> levers();

/// Whether the axis of a plan is a lever of the plant rather than a datum.
bool is_lever(const std::string& axis_key);

/// The key that an axis moves: without ".scale", ".offset" or ".shift".
std::string datum_of(const std::string& axis_key);

/// "± 10 %", "± 3 K", "20..30 degC", "0.5..2 times" of an axis with two ends; else empty.
std::string range_of(const v1::SweepPlan::Axis& axis);

/// The unit of an axis's numbers in SI: "1" of a factor, "s" of a shift in time; empty where the
/// key has no unit or is no number.
std::string unit_of_change(const std::string& axis_key);

/// The number that a text begins with; 0 if it begins with none.
double leading_number(const std::string& text);

/// A number with its unit in four digits: "231.5 degC". @param text  as in a case file
std::string rounded(const std::string& text);

/// Index of the monitor with the name that was asked for; with an empty name that of output.curl,
/// or that with the largest curl at the end.
/// @return -1 where there is none
int monitor_of(const v1::StudyResult& result, const std::string& asked);

}  // namespace dccast::case_file
