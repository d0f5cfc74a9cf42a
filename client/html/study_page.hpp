#pragma once

#include <string>

#include "client/session/plan_requests.hpp"
#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// A self-contained HTML page about a sweep: the final curl against each numeric key and against
/// pairs of such keys, with the table of all runs.
std::string sweep_page(const v1::StudyResult& result);

/// A self-contained HTML page about a mould design: mould and cold slab of every run, their
/// deviation from flatness, and the tables shown in the terminal.
std::string mould_page(const MouldDesign& design);

}  // namespace dccast::client::render
