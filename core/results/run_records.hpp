#pragma once

#include "core/restart/sections.hpp"
#include "core/results/frame.hpp"

/// Conversion of the header and a frame of a run to the sections of a journal record, and
/// back.
namespace dccast::results {

restart::Sections to_sections(const RunHeader& header);
restart::Sections to_sections(const Frame& frame);
/// @throws std::out_of_range  a section is missing: the record was written by other software
RunHeader header_of(const restart::Sections& content);
Frame frame_of(const restart::Sections& content);

}  // namespace dccast::results
