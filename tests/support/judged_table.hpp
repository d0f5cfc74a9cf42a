#pragma once

#include <string>

#include "dccast/v1/judgement.pb.h"

namespace dccast::support {

/// The table of a judgement with this key; empty where there is none.
inline v1::Table table_of(const v1::Judgement& judgement, const std::string& key) {
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.table().key() == key) return part.table();
  return {};
}

}  // namespace dccast::support
