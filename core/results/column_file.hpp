#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace dccast::results {

/// One dataset of a file of columns.
struct FileColumn {
  std::string object;   ///< "/runs/number"
  const char* unit;     ///< null for texts
  const char* meaning;  ///< for a reader of the file
  /// Flat with the last index fastest.
  std::variant<std::vector<double>, std::vector<std::int32_t>, std::vector<std::int64_t>,
               std::vector<std::string>>
      values;
  std::vector<std::size_t> shape{};  ///< of a matrix
};

/// A file of columns, with attributes of its own.
struct ColumnFile {
  std::vector<std::pair<const char*, std::variant<std::int64_t, std::string>>> attributes;
  std::vector<FileColumn> columns;  ///< those of a group one after the other
};

/// Writes it as HDF5. Equal contents give identical files. @throws storage::StorageError
void write_columns(const std::filesystem::path& path, const ColumnFile& content);

}  // namespace dccast::results
