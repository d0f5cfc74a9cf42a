#pragma once

#include <string>

#include "client/mould_design.hpp"

namespace dccast::client::render {

/// One HTML page about a mould design that opens from disk: the mould and the cold slab of every
/// run, how far each is from flat, and the tables of the terminal.
std::string mould_page(const MouldDesign& design);

}  // namespace dccast::client::render
