#include "client/model/case_changes.hpp"

#include "proto/case_file/override.hpp"

namespace dccast::client {

std::vector<v1::CaseChange> changes_of(const std::vector<std::string>& texts) {
  std::vector<v1::CaseChange> changes;
  for (const std::string& text : texts)
    if (auto change = case_file::parse_change(text)) changes.push_back(std::move(*change));
  return changes;
}

}  // namespace dccast::client
