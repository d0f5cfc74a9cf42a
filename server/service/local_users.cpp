#include <pwd.h>

#include <vector>

#include "server/service/gate.hpp"

namespace dccast::service {

std::string user_name(unsigned id) {
  passwd entry;
  passwd* found = nullptr;
  std::vector<char> texts(16384);
  const int error = ::getpwuid_r(id, &entry, texts.data(), texts.size(), &found);
  return error == 0 && found != nullptr ? entry.pw_name : std::to_string(id);
}

std::optional<unsigned> user_id(const std::string& name) {
  passwd entry;
  passwd* found = nullptr;
  std::vector<char> texts(16384);
  const int error = ::getpwnam_r(name.c_str(), &entry, texts.data(), texts.size(), &found);
  return error == 0 && found != nullptr ? std::optional<unsigned>(entry.pw_uid) : std::nullopt;
}

std::string LocalUsers::name_of(unsigned id) {
  const std::lock_guard lock(mutex_);
  const auto [found, is_new] = names_.try_emplace(id);
  if (is_new) found->second = user_name(id);
  return found->second;
}

}  // namespace dccast::service
