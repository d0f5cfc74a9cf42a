#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace dccast::verification {

/// What one verification run found. Errors are relative.
struct Figures {
  double displacement_error = 0.0;
  double stress_error = 0.0;
  double iterations_per_step = 0.0;
  double cpu_s = 0.0;
  long elements = 0;
  long nodes = 0;
  long steps = 0;
  std::map<std::string, double> more;  ///< what else this test reports
  std::vector<double> displacement;    ///< by unknown, at the end [m]; empty where it means nothing
};

/// A run that did not get to its end.
struct Failed {
  double time = 0.0;
  std::string why;
};

/// Seconds of processor time this thread has used.
double cpu_seconds();

}  // namespace dccast::verification
