#pragma once

#include <string>

#include "tests/verification/mechanics/t1.hpp"

namespace dccast::verification {

struct ReportOptions {
  bool nightly = false;
  bool no_casting = false;
  double limit = 600.0;  ///< [s] of table 11
};

/// Every figure, table and plot in one HTML page that needs nothing besides itself.
std::string html_report(const ReportOptions& options);

/// Shear stress sigma_23 of T1 with a fictitious liquid, as the paper's figures 9 to 11: SVG.
std::string shear_picture(const FictitiousLiquid& liquid);

}  // namespace dccast::verification
