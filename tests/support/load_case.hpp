#pragma once

#include <filesystem>
#include <string>

#include "core/casting/case/case.hpp"

namespace dccast::v1 {
class Case;
enum Quality : int;
}  // namespace dccast::v1

namespace dccast::support {

/// Loads a case as the service would run it, with its defaults and its alloy card.
/// @param name  path of a file, or name of a shipped case
/// @throws std::runtime_error  the case has faults; the message lists all of them
casting::Case load_case(const std::string& name);

/// Loads a case in another quality than that of the file.
casting::Case load_case(const std::string& name, v1::Quality quality);

/// A case that names no file, as the service would run it.
/// @throws std::runtime_error  it has faults
casting::Case complete_case(v1::Case description);

/// Sets the mesh and the time steps for which algorithms are compared and the paper's tables are
/// computed: the size of the paper's section 5.2, 30 x 22 cells graded to 3 mm at the side and the
/// bottom.
void take_paper_size(casting::Case& casting_case);

}  // namespace dccast::support
