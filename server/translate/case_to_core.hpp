#pragma once

#include <filesystem>

#include "core/case/case.hpp"
#include "dccast/v1/case.pb.h"

namespace dccast::translate {

/// The core's form of a case.
/// @param complete     with defaults and alloy card filled in, checked against the schema; what is
///                     absent all the same keeps the core's default
/// @param attachments  folder of the files the case names; the names become paths below it
casting::Case to_core(const v1::Case& complete, const std::filesystem::path& attachments);

/// A table; an absent one (no points) becomes an empty curve.
Curve to_core(const v1::Curve& curve);

}  // namespace dccast::translate
