#pragma once

#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"

namespace dccast::client {

/// The changes given by the user as KEY=VALUE, in order.
std::vector<v1::CaseChange> changes_of(const std::vector<std::string>& texts);

/// "schedule.hold = 5 s, mesh.rows = 30"; empty for none.
template <class Changes>
std::string changes_text(const Changes& changes) {
  std::string text;
  for (const v1::CaseChange& change : changes)
    text += (text.empty() ? "" : ", ") + change.key() + " = " + change.value();
  return text;
}

}  // namespace dccast::client
