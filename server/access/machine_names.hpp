#pragma once

#include <string>
#include <vector>

namespace dccast::access {

/// Names by which clients may reach this machine: its host name, its addresses, and loopback.
std::vector<std::string> host_names();

}  // namespace dccast::access
