#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/judgement.pb.h"
#include "dccast/v1/line.pb.h"

/// Figures of a case as a plant reads them.
namespace dccast::case_file {

inline constexpr double mm_per_min = 60e3;  ///< [(mm/min)/(m/s)]
inline constexpr double litres_per_min_per_m =
    60e3;  ///< [(l/(min m))/(m2/s)] litres per minute and metre of perimeter
inline constexpr double m3_per_hour = 3600.0;  ///< [(m3/h)/(m3/s)]

/// A number [any unit] with four significant digits, without trailing zeros; "-" if not finite.
std::string plant_number(double value);

/// A length [m] so, in millimetres: "570 mm".
std::string plant_mm(double metres);

/// A flow in all, "45 m3/h", per metre of perimeter, for a fault: "45 m3/h is the flow of all
/// faces; over the perimeter of 3.78 m it is \"198.4 l/min/m\"". Empty: the text is no such flow.
std::string flow_per_metre_hint(const v1::Section& section, const std::string& flow);

/// A table in words: "40 mm/min to 60 s, then to 60 mm/min at 200 s".
/// @param factor  [`unit` per stored unit]
std::string curve_in_words(const v1::Curve& curve, double factor, const std::string& unit);

/// How a casting went: "bled-out"; empty: it is not known.
std::string outcome_word(v1::LineCasting::Outcome outcome);
/// Empty: no outcome is named so.
std::optional<v1::LineCasting::Outcome> outcome_of(const std::string& word);
/// "sound, bled-out, cracked, hung-up, aborted", or those of them from `first` on.
std::string outcome_words(v1::LineCasting::Outcome first = v1::LineCasting::SOUND);

/// A case as readable TOML: speeds in mm/min, water in l/min/m, numbers rounded to nine digits.
std::string readable_toml(const v1::Case& input);

/// The casting of a case as a plant puts it, in one line: "slab 1320 x 570 mm of aa5182, speed 45
/// -> 55 mm/min from 60 s to 200 s (over 117 mm), water 110 -> 198 l/min/m = 25 -> 45 m3/h". Speed
/// and water are those that the levers leave, with the values at which they turn.
std::string casting_summary(const v1::Case& complete);

/// Charts of its speed and its water, as the levers leave them, from the begin of the casting to
/// its end: against cast length where the tables are.
std::vector<v1::Chart> planned_charts(const v1::Case& complete);

}  // namespace dccast::case_file
