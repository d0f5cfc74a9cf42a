#pragma once

#include <optional>
#include <string>

namespace dccast::figures {

/// A number [any unit] with a fixed number of decimals; "-" if it is not finite. Zero has no sign.
std::string fixed(double value, int decimals);

/// A length [m] in millimetres, likewise.
std::string mm(double metres, int decimals = 1);

/// Decimals that show an error [any unit] with so many digits, 0 to `most`; `most` without an
/// error.
int decimals_by_error(const std::optional<double>& error, int digits, int most);

/// Decimals of a curl in millimetres: two digits of its error [m], and no finer than hundredths.
int mm_decimals(const std::optional<double>& error_m);

/// Errors without unit: "± 0.36"; "-0 +4.9" where they differ.
/// @param lower, upper  how far the true figure may lie below and above
std::string errors_text(double lower, double upper, int decimals);

/// Those of a curl [m], in millimetres.
std::string mm_errors(double lower_m, double upper_m, int decimals);

/// A figure with its errors as above: "12.3 ± 1.4", "35.5, -0 +3.9".
std::string with_errors(const std::string& figure, const std::string& errors);

}  // namespace dccast::figures
