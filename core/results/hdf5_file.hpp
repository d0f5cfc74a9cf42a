#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// Wrapper of the HDF5 C library: identifiers that close themselves, and failures as
/// storage::StorageError with file, object and the cause reported by the library. Only this room
/// includes the library.
namespace dccast::results::hdf5 {

/// An HDF5 identifier with the function that closes it.
class Handle {
public:
  /// Function of the library that closes this kind of identifier.
  using Close = herr_t (*)(hid_t);
  /// A handle without identifier, and one that owns `id`.
  Handle() = default;
  Handle(hid_t id, Close close_function) : id_(id), close_(close_function) {}
  Handle(Handle&& other) noexcept
      : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  hid_t get() const { return id_; }
  /// Closes the identifier. @return the library's result: negative if data could not be written
  herr_t close() { return close_(std::exchange(id_, H5I_INVALID_HID)); }

private:
  hid_t id_ = H5I_INVALID_HID;
  Close close_ = nullptr;
};

/// Numbers of values by index, the slowest first.
using Shape = std::vector<hsize_t>;

/// Number of values in an array of this shape.
std::size_t count_values(const Shape& shape);

/// An HDF5 file. Objects are addressed by their absolute path in the file.
class File {
public:
  /// Creates a file, overwriting an existing one. The format can be read by HDF5 1.8.
  /// @throws storage::StorageError
  static File create(const std::filesystem::path& path);
  /// Opens a file for reading. @throws storage::StorageError  missing, not HDF5, or damaged
  static File open(const std::filesystem::path& path);

  /// @throws storage::StorageError  it exists, or a group above it does not
  void create_group(const std::string& object);
  /// Writes a dataset.
  /// @param shape          row-major; large arrays are chunked, compressed and get a checksum
  /// @tparam Number        double, std::int32_t or std::int64_t
  /// @param values         [`unit`] flat with the last index fastest
  /// @param unit, meaning  stored as the attributes `unit`, `units` (as CF names it) and `meaning`
  template <class Number>
  void write(const std::string& object, const Shape& shape, const std::vector<Number>& values,
             const char* unit, const char* meaning);
  /// Writes a one-dimensional dataset.
  template <class Number>
  void write(const std::string& object, const std::vector<Number>& values, const char* unit,
             const char* meaning) {
    write(object, {values.size()}, values, unit, meaning);
  }
  /// Writes an array of UTF-8 strings, flat with the last index fastest.
  void write_texts(const std::string& object, const Shape& shape,
                   const std::vector<std::string>& texts, const char* meaning);
  void write_texts(const std::string& object, const std::vector<std::string>& texts,
                   const char* meaning) {
    write_texts(object, {texts.size()}, texts, meaning);
  }
  /// Attributes have no unit of their own; their names end in it, e.g. `time_s` [s].
  void write_attribute(const std::string& object, const char* name, double value);
  void write_attribute(const std::string& object, const char* name, std::int64_t value);
  void write_attribute(const std::string& object, const char* name, const std::string& value);

  /// Makes a dataset the scale of a dimension of another one, as HDF5 and netCDF know it: its
  /// values belong to the places along that dimension.
  void attach_scale(const std::string& scale, const std::string& object, unsigned dimension);

  /// Whether an object exists at a path; shape of a dataset. @throws storage::StorageError of
  /// shape_of(): it is none
  bool has(const std::string& object) const;
  Shape shape_of(const std::string& object) const;
  /// Reads all values of a dataset.
  /// @param count  if given, the required number of values
  /// @return [unit of the dataset]
  std::vector<double> read_reals(const std::string& object,
                                 std::optional<std::size_t> count = {}) const;
  /// As read_reals(), for integers and texts; texts are UTF-8. @throws storage::StorageError
  std::vector<std::int64_t> read_integers(const std::string& object,
                                          std::optional<std::size_t> count = {}) const;
  std::vector<std::string> read_texts(const std::string& object,
                                      std::optional<std::size_t> count = {}) const;
  /// Attributes of an object; a missing one is a StorageError unless has_attribute() says so
  /// before.
  bool has_attribute(const std::string& object, const char* name) const;
  /// @return [unit in the name of the attribute]
  double real_attribute(const std::string& object, const char* name) const;
  std::int64_t integer_attribute(const std::string& object, const char* name) const;
  std::string text_attribute(const std::string& object, const char* name) const;

  /// Flushes and closes the file. @throws storage::StorageError  also if the disk is full
  void close();
  const std::filesystem::path& path() const { return path_; }

private:
  File(std::filesystem::path path, Handle id) : path_(std::move(path)), id_(std::move(id)) {}
  /// @param unit  null for texts
  void write_array(const std::string& object, const Shape& shape, hid_t file_type,
                   hid_t memory_type, const void* values, const char* unit, const char* meaning);
  /// @param target  the open object
  /// @param object  its path, for messages
  void put_attribute(const Handle& target, const std::string& object, const char* name, hid_t type,
                     const void* value);
  void put_attribute(const Handle& target, const std::string& object, const char* name,
                     const char* text);
  /// @throws storage::StorageError  there is no such object
  Handle open_object(const std::string& object) const;
  /// @param type   HDF5 type of the value in memory
  /// @param value  room for one value of this type
  void read_attribute(const std::string& object, const char* name, hid_t type, void* value) const;
  /// Number of values of a dataset, checked against the size of its file.
  /// @param required  see read_reals()
  std::size_t checked_count(const std::string& object, std::optional<std::size_t> required) const;
  /// Reads a whole dataset into memory whose size has been checked.
  void read_array(const std::string& object, hid_t memory_type, void* values) const;
  /// Passes on the result of a call of the library.
  /// @throws storage::StorageError  `result` is negative; `failure` says what could not be done
  template <class Result>
  Result checked(Result result, const std::string& object, const char* failure) const;

  std::filesystem::path path_;
  Handle id_;
};

}  // namespace dccast::results::hdf5
