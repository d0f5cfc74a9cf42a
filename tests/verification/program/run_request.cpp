#include "tests/verification/program/run_request.hpp"

#include <sstream>
#include <stdexcept>

namespace dccast::verification {

std::string name_of(mesh::ElementKind element) {
  switch (element) {
    case mesh::ElementKind::p1:
      return "p1";
    case mesh::ElementKind::q1:
      return "q1";
    case mesh::ElementKind::q1_bending:
      return "q1_bending";
  }
  throw std::logic_error("name_of: an element without a name");
}

std::string name_of(mechanics::Algorithm algorithm) {
  switch (algorithm) {
    case mechanics::Algorithm::newton:
      return "newton";
    case mechanics::Algorithm::vnbm:
      return "vnbm";
    case mechanics::Algorithm::sbm:
      return "sbm";
    case mechanics::Algorithm::nbm:
      return "nbm";
  }
  throw std::logic_error("name_of: an algorithm without a name");
}

std::string command_of(const RunRequest& request) {
  std::ostringstream out;
  out << "dccast-verify run " << request.name;
  if (request.algorithm != mechanics::Algorithm::newton) {
    out << " --algorithm " << name_of(request.algorithm);
  }
  if (request.dt) out << " --dt " << *request.dt;
  if (request.cells > 0) out << " --cells " << request.cells;
  if (request.element != mesh::ElementKind::p1) out << " --element " << name_of(request.element);
  if (request.plain) out << " --plain";
  if (request.cut_steps) out << " --cut-steps";
  if (request.increment_test) out << " --increment-test";
  if (request.tolerance) out << " --tolerance " << *request.tolerance;
  if (request.end) out << " --end " << *request.end;
  if (request.liquid) {
    out << " --epsilon " << request.liquid->epsilon << " --delta " << request.liquid->delta
        << " --beta " << request.liquid->beta;
  }
  if (request.diagonals == Diagonals::mirrored_back) out << " --diagonals mirrored-back";
  if (!request.data.empty()) out << " --data " << request.data.string();
  return out.str();
}

}  // namespace dccast::verification
