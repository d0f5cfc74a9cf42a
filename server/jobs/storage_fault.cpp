#include "server/jobs/storage_fault.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <new>
#include <system_error>

#include "core/storage/storage_error.hpp"
#include "server/jobs/sqlite.hpp"

namespace dccast::jobs {

namespace {

constexpr std::array passing_store_errors{SQLITE_FULL,     SQLITE_IOERR, SQLITE_READONLY,
                                          SQLITE_CANTOPEN, SQLITE_BUSY,  SQLITE_NOMEM};

}  // namespace

std::optional<std::string> daemon_lacks(const std::exception& error) {
  bool lacks = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
  if (const auto* system = dynamic_cast<const std::system_error*>(&error))
    lacks = storage::is_resource_fault(system->code());
  if (const auto* store = dynamic_cast<const StoreError*>(&error))
    lacks = std::ranges::find(passing_store_errors, store->code()) != passing_store_errors.end();
  return lacks ? std::optional<std::string>(error.what()) : std::nullopt;
}

}  // namespace dccast::jobs
