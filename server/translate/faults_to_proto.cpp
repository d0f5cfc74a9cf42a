#include "server/translate/faults_to_proto.hpp"

namespace dccast::translate {

namespace {

v1::Fault to_proto(const Fault& from) {
  v1::Fault to;
  to.set_field(from.field);
  to.set_value(from.value);
  to.set_message(from.message);
  to.set_permitted(from.permitted);
  to.set_remedy(from.remedy);
  return to;
}

}  // namespace

v1::ValidateCaseResponse to_proto(const casting::CheckedCase& checked) {
  v1::ValidateCaseResponse verdict;
  for (const Fault& fault : checked.faults.list()) *verdict.add_faults() = to_proto(fault);
  for (const Fault& warning : checked.warnings.list()) *verdict.add_warnings() = to_proto(warning);
  if (!checked.faults.empty()) return verdict;
  auto* estimate = verdict.mutable_estimate();
  estimate->set_nodes(checked.estimate.nodes);
  estimate->set_elements(checked.estimate.elements);
  estimate->set_steps(checked.estimate.steps);
  estimate->set_solver_s(checked.estimate.solver_seconds);
  estimate->set_memory_bytes(checked.estimate.memory_bytes);
  return verdict;
}

std::string in_words(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) {
    if (!text.empty()) text += "; ";
    text += fault.field + " = " + fault.value + ": " + fault.message;
    if (!fault.permitted.empty()) text += " (" + fault.permitted + ")";
  }
  return text;
}

}  // namespace dccast::translate
