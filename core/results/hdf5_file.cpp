#include "core/results/hdf5_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <new>
#include <numeric>

#include "core/storage/storage_error.hpp"

namespace dccast::hdf5 {

namespace {

/// Below this many values a checksum and compression cost more than they give: each chunked array
/// has an index of 2 KB, and unpacked the frames of a start case are a third longer.
constexpr std::size_t smallest_chunked = 4096;
/// One chunk is at most this long, so that a reader of a part need not unpack the whole.
constexpr hsize_t chunk_values = 1 << 17;
/// Higher levels take longer and save nothing on shuffled doubles (2.6 MB for 22 frames at 1 and
/// 4).
constexpr unsigned deflate_level = 1;
/// Deflate makes at most 1032 bytes of one; so many values need not be stored at all (fill values).
/// A damaged or hostile file of kilobytes asks for megabytes, not for all the memory.
constexpr double most_values_per_byte = 1032.0;
constexpr double most_values_of_nothing = 1e6;

/// The cause of the last failure as reported by the library: the innermost message and the system
/// error number.
struct LibraryError {
  std::string message;
  int system_code = EIO;
};

/// Called with the library's lock held, which an exception would leave locked for ever.
herr_t keep_innermost(unsigned depth, const H5E_error2_t* entry, void* into) try {
  auto& error = *static_cast<LibraryError*>(into);
  // The rest repeats time, file and buffer; the error number is reported separately.
  if (depth == 0)
    error.message = std::string(entry->desc).substr(0, std::string(entry->desc).find(": time ="));
  if (entry->maj_num == H5E_RESOURCE) error.system_code = ENOMEM;
  // The library hands errno over as text only.
  const std::string text = entry->desc;
  const std::string key = "errno = ";
  if (const auto at = text.find(key); at != std::string::npos)
    error.system_code = std::atoi(text.c_str() + at + key.size());
  return 0;
} catch (const std::bad_alloc&) {
  static_cast<LibraryError*>(into)->system_code = ENOMEM;
  return -1;
}

LibraryError last_error() {
  LibraryError error;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &error);
  return error;
}

/// Otherwise the library prints every failure to stderr, even those that are handled. The setting
/// is per thread.
void be_quiet() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

/// How the file and this program store a number.
std::pair<hid_t, hid_t> types_of(double) {
  return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE};
}

std::pair<hid_t, hid_t> types_of(std::int32_t) {
  return {H5T_STD_I32LE, H5T_NATIVE_INT32};
}

std::pair<hid_t, hid_t> types_of(std::int64_t) {
  return {H5T_STD_I64LE, H5T_NATIVE_INT64};
}

Handle space_of(const Shape& shape) {
  if (shape.empty()) return {H5Screate(H5S_SCALAR), H5Sclose};
  return {H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose};
}

/// How a dataset is laid out. Times are not stored: the same run gives the same bytes.
Handle layout_of(const Shape& shape) {
  Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(layout.get(), false);
  if (shape.empty() || count_of(shape) < smallest_chunked) return layout;
  const hsize_t row = count_of(shape) / shape[0];
  Shape chunk = shape;
  chunk[0] = std::min(shape[0], std::max<hsize_t>(1, chunk_values / row));
  H5Pset_chunk(layout.get(), static_cast<int>(chunk.size()), chunk.data());
  H5Pset_shuffle(layout.get());
  H5Pset_deflate(layout.get(), deflate_level);
  H5Pset_fletcher32(layout.get());
  return layout;
}

/// Takes over the strings HDF5 allocated.
std::vector<std::string> take_texts(std::vector<char*>& texts) {
  std::vector<std::string> taken;
  taken.reserve(texts.size());
  for (char* text : texts) {
    taken.emplace_back(text == nullptr ? "" : text);
    H5free_memory(text);
  }
  return taken;
}

}  // namespace

std::size_t count_of(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
}

template <class Answer>
Answer File::checked(Answer answer, const std::string& object, const char* what) const {
  if (answer >= 0) return answer;
  const LibraryError cause = last_error();
  throw storage::StorageError(cause.system_code, path_.string() + ":" + object,
                              std::string(what) + " (" + cause.message + ")");
}

File File::create(const std::filesystem::path& path) {
  be_quiet();
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_EARLIEST, H5F_LIBVER_V18);
  File file(path,
            Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose));
  file.checked(file.id_.get(), "/", "cannot be created");
  return file;
}

File File::open(const std::filesystem::path& path) {
  be_quiet();
  File file(path, Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose));
  file.checked(file.id_.get(), "/", "cannot be opened as HDF5");
  return file;
}

void File::create_group(const std::string& object) {
  const Handle group(H5Gcreate2(id_.get(), object.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                     H5Gclose);
  checked(group.get(), object, "cannot be created");
}

void File::write_array(const std::string& object, const Shape& shape, hid_t file_type,
                       hid_t memory_type, const void* values, const char* unit,
                       const char* meaning) {
  const Handle space = space_of(shape);
  const Handle layout = layout_of(unit == nullptr ? Shape{} : shape);  // texts are not chunked
  const Handle dataset(H5Dcreate2(id_.get(), object.c_str(), file_type, space.get(), H5P_DEFAULT,
                                  layout.get(), H5P_DEFAULT),
                       H5Dclose);
  checked(dataset.get(), object, "cannot be created");
  if (count_of(shape) > 0)
    checked(H5Dwrite(dataset.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), object,
            "cannot be written");
  if (unit != nullptr) put_attribute(dataset, object, "unit", unit);
  put_attribute(dataset, object, "meaning", meaning);
}

template <class Number>
void File::write(const std::string& object, const Shape& shape, const std::vector<Number>& values,
                 const char* unit, const char* meaning) {
  const auto [in_file, in_memory] = types_of(Number{});
  write_array(object, shape, in_file, in_memory, values.data(), unit, meaning);
}

template void File::write(const std::string&, const Shape&, const std::vector<double>&, const char*,
                          const char*);
template void File::write(const std::string&, const Shape&, const std::vector<std::int32_t>&,
                          const char*, const char*);
template void File::write(const std::string&, const Shape&, const std::vector<std::int64_t>&,
                          const char*, const char*);

void File::write_texts(const std::string& object, const Shape& shape,
                       const std::vector<std::string>& texts, const char* meaning) {
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  const Handle type = text_type();
  write_array(object, shape, type.get(), type.get(), pointers.data(), nullptr, meaning);
}

void File::put_attribute(const Handle& target, const std::string& object, const char* name,
                         hid_t type, const void* value) {
  const Handle space = space_of({});
  const Handle attribute(
      H5Acreate2(target.get(), name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  checked(attribute.get(), object + "@" + name, "cannot be created");
  checked(H5Awrite(attribute.get(), type, value), object + "@" + name, "cannot be written");
}

void File::put_attribute(const Handle& target, const std::string& object, const char* name,
                         const char* text) {
  const Handle type = text_type();
  put_attribute(target, object, name, type.get(), &text);
}

void File::write_attribute(const std::string& object, const char* name, double value) {
  put_attribute(open_object(object), object, name, H5T_NATIVE_DOUBLE, &value);
}

void File::write_attribute(const std::string& object, const char* name, std::int64_t value) {
  put_attribute(open_object(object), object, name, H5T_NATIVE_INT64, &value);
}

void File::write_attribute(const std::string& object, const char* name, const std::string& value) {
  put_attribute(open_object(object), object, name, value.c_str());
}

Handle File::open_object(const std::string& object) const {
  Handle opened(H5Oopen(id_.get(), object.c_str(), H5P_DEFAULT), H5Oclose);
  checked(opened.get(), object, "is not in the file");
  return opened;
}

void File::read_attribute(const std::string& object, const char* name, hid_t type,
                          void* value) const {
  const std::string whole_name = object + "@" + name;
  const Handle owner = open_object(object);
  const Handle attribute(H5Aopen(owner.get(), name, H5P_DEFAULT), H5Aclose);
  checked(attribute.get(), whole_name, "is not in the file");
  const Handle space(H5Aget_space(attribute.get()), H5Sclose);
  if (H5Sget_simple_extent_npoints(space.get()) != 1)
    throw storage::StorageError(EINVAL, path_.string() + ":" + whole_name, "is not one value");
  checked(H5Aread(attribute.get(), type, value), whole_name, "cannot be read");
}

bool File::has(const std::string& object) const {
  return H5Lexists(id_.get(), object.c_str(), H5P_DEFAULT) > 0;
}

Shape File::shape_of(const std::string& object) const {
  const Handle dataset = open_object(object);
  const Handle space(H5Dget_space(dataset.get()), H5Sclose);
  checked(space.get(), object, "is not a dataset");
  Shape shape(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space.get())));
  H5Sget_simple_extent_dims(space.get(), shape.data(), nullptr);
  return shape;
}

/// The product of the lengths is not to be trusted before it is compared with what is stored.
std::size_t File::count_in(const std::string& object, std::optional<std::size_t> wanted) const {
  const Handle dataset = open_object(object);
  const double stored = std::min(static_cast<double>(H5Dget_storage_size(dataset.get())),
                                 static_cast<double>(std::filesystem::file_size(path_)));
  const Shape shape = shape_of(object);
  double count = 1.0;
  for (const hsize_t length : shape) count *= static_cast<double>(length);
  if (count > most_values_of_nothing + most_values_per_byte * stored ||
      (wanted && count_of(shape) != *wanted))
    throw storage::StorageError(EINVAL, path_.string() + ":" + object, "has the wrong shape");
  return count_of(shape);
}

void File::read_array(const std::string& object, hid_t memory_type, void* values) const {
  const Handle dataset = open_object(object);
  checked(H5Dread(dataset.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), object,
          "cannot be read");
}

std::vector<double> File::read_reals(const std::string& object,
                                     std::optional<std::size_t> count) const {
  std::vector<double> values(count_in(object, count));
  if (!values.empty()) read_array(object, H5T_NATIVE_DOUBLE, values.data());
  return values;
}

std::vector<std::int64_t> File::read_integers(const std::string& object,
                                              std::optional<std::size_t> count) const {
  std::vector<std::int64_t> values(count_in(object, count));
  if (!values.empty()) read_array(object, H5T_NATIVE_INT64, values.data());
  return values;
}

std::vector<std::string> File::read_texts(const std::string& object,
                                          std::optional<std::size_t> count) const {
  std::vector<char*> texts(count_in(object, count), nullptr);
  const Handle type = text_type();
  if (!texts.empty()) read_array(object, type.get(), texts.data());
  return take_texts(texts);
}

bool File::has_attribute(const std::string& object, const char* name) const {
  return H5Aexists_by_name(id_.get(), object.c_str(), name, H5P_DEFAULT) > 0;
}

double File::real_attribute(const std::string& object, const char* name) const {
  double value = 0.0;
  read_attribute(object, name, H5T_NATIVE_DOUBLE, &value);
  return value;
}

std::int64_t File::integer_attribute(const std::string& object, const char* name) const {
  std::int64_t value = 0;
  read_attribute(object, name, H5T_NATIVE_INT64, &value);
  return value;
}

std::string File::text_attribute(const std::string& object, const char* name) const {
  const Handle type = text_type();
  std::vector<char*> texts(1, nullptr);
  read_attribute(object, name, type.get(), texts.data());
  return take_texts(texts).front();
}

void File::close() {
  checked(H5Fflush(id_.get(), H5F_SCOPE_GLOBAL), "/", "cannot be written");
  checked(id_.close(), "/", "cannot be closed");
}

}  // namespace dccast::hdf5
