#include "server/translate/faults_to_proto.hpp"

#include "proto/values/printable.hpp"

namespace dccast::translate {

namespace {

/// Names out of a mesh file, say, are bytes of any kind; a message takes UTF-8 alone.
std::string escaped(const std::string& text) {
  return values::escaped(text, values::Lines::several);
}

v1::Fault to_proto(const Fault& from) {
  v1::Fault to;
  to.set_field(escaped(from.field));
  to.set_value(escaped(from.value));
  to.set_message(escaped(from.message));
  to.set_permitted(escaped(from.permitted));
  to.set_remedy(escaped(from.remedy));
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
  return escaped(text);
}

}  // namespace dccast::translate
