#include "server/relay/held_memory.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace dccast::relay {

namespace {

/// A user, or the strangers of a machine.
using Holder = std::pair<bool, std::string>;

Holder holder_of(const HeldMemory& connection) {
  const bool is_stranger = connection.user.empty();
  return {is_stranger, is_stranger ? connection.machine : connection.user};
}

using Sums = std::map<Holder, std::size_t>;

Sums::const_iterator largest_of(const Sums& sums) {
  return std::ranges::max_element(sums, {}, &Sums::value_type::second);
}

}  // namespace

std::optional<std::size_t> beyond_bounds(const std::vector<HeldMemory>& connections,
                                         const MemoryBounds& bounds) {
  Sums users, machines;
  std::size_t of_users = 0, of_strangers = 0;
  for (const HeldMemory& connection : connections) {
    const Holder holder = holder_of(connection);
    (holder.first ? machines : users)[holder] += connection.bytes;
    (holder.first ? of_strangers : of_users) += connection.bytes;
  }

  const auto most_of_machine = largest_of(machines), most_of_user = largest_of(users);
  const Holder* beyond = nullptr;
  if (most_of_machine != machines.end() &&
      (of_strangers > bounds.of_strangers || most_of_machine->second > bounds.of_machine))
    beyond = &most_of_machine->first;
  else if (most_of_user != users.end() &&
           (of_users + of_strangers > bounds.all || most_of_user->second > bounds.of_user))
    beyond = &most_of_user->first;
  if (beyond == nullptr) return std::nullopt;

  // The one that holds most of those of this holder.
  std::optional<std::size_t> largest;
  for (std::size_t i = 0; i < connections.size(); ++i)
    if (holder_of(connections[i]) == *beyond &&
        (!largest || connections[i].bytes > connections[*largest].bytes))
      largest = i;
  return largest;
}

}  // namespace dccast::relay
