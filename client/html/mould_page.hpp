#pragma once

#include <string>

#include "client/session/mould_design.hpp"

namespace dccast::client::render {

/// A self-contained HTML page about a mould design: mould and cold slab of every run, their
/// deviation from flatness, and the tables shown in the terminal.
std::string mould_page(const MouldDesign& design);

}  // namespace dccast::client::render
