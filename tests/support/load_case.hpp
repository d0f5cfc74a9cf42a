#pragma once

#include <filesystem>
#include <string>

#include "core/case/case.hpp"

namespace dccast::v1 {
enum Quality : int;
}

namespace dccast::support {

/// A case file as the service would run it: defaults and alloy card filled in.
/// @param name  path of a file, or name of a shipped case
/// @throws std::runtime_error  with every fault, when it has any
casting::Case load_case(const std::string& name);

/// The same in another quality than the file says.
casting::Case load_case(const std::string& name, v1::Quality quality);

/// The mesh and the steps in which the algorithms are compared and the paper's tables are made, of
/// the size of the paper's section 5.2: 30 x 22 cells graded to 3 mm at the side and the bottom.
void take_paper_size(casting::Case& casting_case);

}  // namespace dccast::support
