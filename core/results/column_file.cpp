#include "core/results/column_file.hpp"

#include <type_traits>

#include "core/results/hdf5_file.hpp"

namespace dccast::results {

namespace {

void write(const FileColumn& column, hdf5::File& file) {
  std::visit(
      [&](const auto& values) {
        hdf5::Shape shape(column.shape.begin(), column.shape.end());
        if (shape.empty()) shape = {values.size()};
        if constexpr (std::is_same_v<decltype(values), const std::vector<std::string>&>)
          file.write_texts(column.object, shape, values, column.meaning);
        else
          file.write(column.object, shape, values, column.unit, column.meaning);
      },
      column.values);
}

}  // namespace

void write_columns(const std::filesystem::path& path, const ColumnFile& content) {
  hdf5::File file = hdf5::File::create(path);
  for (const auto& [name, value] : content.attributes)
    std::visit([&](const auto& each) { file.write_attribute("/", name, each); }, value);

  std::string group;
  for (const FileColumn& column : content.columns) {
    const std::string own = column.object.substr(0, column.object.rfind('/'));
    if (own != group && !own.empty()) file.create_group(own);
    group = own;
    write(column, file);
  }
  file.close();
}

}  // namespace dccast::results
