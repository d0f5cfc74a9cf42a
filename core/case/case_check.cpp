#include "core/case/case_check.hpp"

#include "core/case/check/checks.hpp"

namespace dccast::casting {

CheckedCase check(const Case& casting_case, const std::vector<std::string>& faulty_keys) {
  CaseFindings found(casting_case, faulty_keys);
  check_alloy(found);
  check_zones(found);
  check_tables(found);
  check_levers(found);
  check_section(found);
  check_quarter_slab(found);
  check_block_profile(found);
  check_time(found);
  check_mechanics(found);
  check_course(found);
  if (casting_case.section.file.empty())
    check_built_in_size(found);
  else
    check_imported_mesh(found);
  check_temperature_file(found);
  check_monitors(found);
  check_plausibility(found);
  advise(found);
  return found.answer();
}

}  // namespace dccast::casting
