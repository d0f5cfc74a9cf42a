#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "tests/verification/mechanics/paper_tests.hpp"
#include "tests/verification/mechanics/t1.hpp"

namespace dccast::verification {

/// One run of one named test, as asked for on the command line. What is absent is the paper's.
struct RunRequest {
  std::string name;
  mechanics::Algorithm algorithm = mechanics::Algorithm::newton;
  std::optional<double> dt;  ///< [s]
  int cells = 0;             ///< per side; 0: the test's own
  mesh::ElementKind element = mesh::ElementKind::p1;
  bool plain = false;                         ///< nbm without its improvements
  bool cut_steps = false;                     ///< halve a failed step even where `plain`
  bool increment_test = false;                ///< stop as the paper does
  std::optional<double> tolerance;            ///< relative residual
  std::optional<double> end;                  ///< [s]
  std::optional<FictitiousLiquid> liquid;     ///< T1 only
  Diagonals diagonals = Diagonals::mirrored;  ///< T1 only
  std::filesystem::path data;                 ///< strand only
};

/// The name by which an element family is asked for, as in a case.
std::string name_of(mesh::ElementKind element);
/// The name by which an algorithm is asked for.
std::string name_of(mechanics::Algorithm algorithm);

/// The request as the command that repeats it.
std::string command_of(const RunRequest& request);

}  // namespace dccast::verification
