#include "server/jobs/storage_fault.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <new>
#include <system_error>

#include "server/jobs/sqlite.hpp"

namespace dccast::jobs {

namespace {

constexpr std::array passing_errors{ENOSPC, EDQUOT, EROFS,  EIO,  EMFILE,
                                    ENFILE, ENOMEM, EAGAIN, EFBIG};
constexpr std::array passing_store_errors{SQLITE_FULL,     SQLITE_IOERR, SQLITE_READONLY,
                                          SQLITE_CANTOPEN, SQLITE_BUSY,  SQLITE_NOMEM};

template <std::size_t count>
bool contains(const std::array<int, count>& codes, int code) {
  return std::ranges::find(codes, code) != codes.end();
}

}  // namespace

std::optional<std::string> daemon_lacks(const std::exception& error) {
  bool lacks = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
  if (const auto* system = dynamic_cast<const std::system_error*>(&error))
    lacks = contains(passing_errors, system->code().value());
  if (const auto* store = dynamic_cast<const StoreError*>(&error))
    lacks = contains(passing_store_errors, store->code());
  return lacks ? std::optional<std::string>(error.what()) : std::nullopt;
}

}  // namespace dccast::jobs
