#include "tests/support/load_case.hpp"

#include <stdexcept>

#include "dccast/v1/case.pb.h"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/shipped.hpp"
#include "server/translate/translate.hpp"

namespace dccast::support {

namespace {

/// @throws std::runtime_error  there are faults
void require_none(const std::vector<v1::Fault>& faults) {
  if (faults.empty()) return;
  std::string text;
  for (const auto& fault : faults) {
    text += fault.field() + " = " + fault.value() + ": " + fault.message() + "\n";
  }
  throw std::runtime_error(text);
}

case_file::ReadOutcome read(const std::string& name, v1::Case& message) {
  for (const auto& shipped : shipped::case_templates()) {
    if (shipped.name == name) return case_file::read_text(shipped.text, name, message);
  }
  return case_file::read_file(name, message);
}

casting::Case complete_case(v1::Case& message, const std::filesystem::path& folder) {
  case_file::apply_defaults(message);
  const auto card = case_file::alloy_card(message.alloy().card());
  require_none(card.faults);
  case_file::complete_alloy(card.alloy, *message.mutable_alloy());
  require_none(case_file::check_ranges(message));
  return translate::to_core(message, folder);
}

}  // namespace

casting::Case complete_case(v1::Case description) {
  return complete_case(description, {});
}

casting::Case load_case(const std::string& name) {
  v1::Case message;
  require_none(read(name, message).faults);
  return complete_case(message, std::filesystem::path(name).parent_path());
}

casting::Case load_case(const std::string& name, v1::Quality quality) {
  v1::Case message;
  require_none(read(name, message).faults);
  message.set_quality(quality);
  return complete_case(message, std::filesystem::path(name).parent_path());
}

void take_paper_size(casting::Case& c) {
  c.section.columns = 30;
  c.section.rows = 22;
  c.section.side_cell = c.section.bottom_cell = 3e-3;
  c.section.growth_cell = 4.9e-3;
  c.time.step = Curve(Abscissa::time, {-60.0, -50.0, -0.001, 0.0, 2.0, 2.001, 10.0, 10.001},
                      {0.25, 1.0, 1.0, 0.05, 0.05, 0.25, 0.25, 1.0});
}

}  // namespace dccast::support
