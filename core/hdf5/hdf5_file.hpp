#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

/// The C library of HDF5 wrapped once: identifiers that close themselves, and failures as
/// storage::StorageError with file, object and the library's own cause. Only this room includes it.
namespace dccast::hdf5 {

/// An identifier with the function that gives it back.
class Handle {
public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Close give_back) : id_(id), close_(give_back) {}
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
  /// Closes now. @return what the library answered: negative where data could not be written
  herr_t close() { return close_(std::exchange(id_, H5I_INVALID_HID)); }

private:
  hid_t id_ = H5I_INVALID_HID;
  Close close_ = nullptr;
};

using Shape = std::vector<hsize_t>;

/// Number of values in an array of that shape.
std::size_t count_of(const Shape& shape);

/// A file of which every object is addressed by its absolute path inside it.
class File {
public:
  /// Over an older file. Versions of the format are bounded to what HDF5 1.8 reads.
  /// @throws storage::StorageError
  static File create(const std::filesystem::path& path);
  /// For reading. @throws storage::StorageError  not there, not HDF5, damaged
  static File open(const std::filesystem::path& path);

  void create_group(const std::string& object);
  /// @param shape  rows first; large arrays are chunked, deflated and get a checksum
  /// @param unit, meaning  of the values, become the attributes `unit` and `meaning`
  void write(const std::string& object, const Shape& shape, const double* values, const char* unit,
             const char* meaning);
  void write(const std::string& object, const Shape& shape, const std::int32_t* values,
             const char* unit, const char* meaning);
  void write(const std::string& object, const Shape& shape, const std::int64_t* values,
             const char* unit, const char* meaning);
  /// A one-dimensional dataset of UTF-8 strings, or a scalar one.
  void write_texts(const std::string& object, const std::vector<std::string>& texts,
                   const char* meaning);
  /// An array of them. @param texts  flat, the last index runs fastest
  void write_texts(const std::string& object, const Shape& shape,
                   const std::vector<std::string>& texts, const char* meaning);
  void write_text(const std::string& object, const std::string& text, const char* meaning);
  void write_attribute(const std::string& object, const char* name, double value);
  void write_attribute(const std::string& object, const char* name, std::int64_t value);
  void write_attribute(const std::string& object, const char* name, const std::string& value);

  bool has(const std::string& object) const;
  Shape shape_of(const std::string& object) const;
  std::vector<double> read_reals(const std::string& object) const;
  std::vector<std::int64_t> read_integers(const std::string& object) const;
  std::vector<std::string> read_texts(const std::string& object) const;
  double real_attribute(const std::string& object, const char* name) const;
  std::int64_t integer_attribute(const std::string& object, const char* name) const;
  std::string text_attribute(const std::string& object, const char* name) const;

  /// Hands everything to the system and closes. @throws storage::StorageError  also on a full disk
  void close();
  const std::filesystem::path& path() const { return path_; }

private:
  File(std::filesystem::path path, Handle id) : path_(std::move(path)), id_(std::move(id)) {}
  void write_array(const std::string& object, const Shape& shape, hid_t file_type,
                   hid_t memory_type, const void* values, const char* unit, const char* meaning);
  void write_strings(const std::string& object, const Handle& space, const char* const* texts,
                     const char* meaning);
  /// @param target  the object itself, open; its path serves the messages
  void put_attribute(const Handle& target, const std::string& object, const char* name, hid_t type,
                     const void* value);
  void put_attribute(const Handle& target, const std::string& object, const char* name,
                     const char* text);
  Handle open_object(const std::string& object) const;
  Handle open_attribute(const std::string& object, const char* name) const;
  void read_array(const std::string& object, hid_t memory_type, void* values) const;
  /// @throws storage::StorageError  where `answer` is negative
  template <class Answer>
  Answer checked(Answer answer, const std::string& object, const char* what) const;

  std::filesystem::path path_;
  Handle id_;
};

}  // namespace dccast::hdf5
