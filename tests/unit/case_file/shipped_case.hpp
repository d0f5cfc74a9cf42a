#pragma once

#include <gtest/gtest.h>

#include <string>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/shipped.hpp"

namespace dccast::case_file {

/// A shipped case at draft, as it is written: without its defaults.
inline v1::Case shipped_case(const std::string& name) {
  v1::Case description;
  const auto* const shipped = shipped::find(shipped::case_templates(), name);
  EXPECT_TRUE(read_text(shipped->text, name, description).ok());
  description.set_quality(v1::DRAFT);
  return description;
}

}  // namespace dccast::case_file
