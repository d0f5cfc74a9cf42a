#include "core/results/hdf5_file.hpp"

#include <fmt/format.h>

#include <hdf5_hl.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <new>
#include <numeric>

#include "core/storage/storage_error.hpp"

namespace dccast::results::hdf5 {

namespace {

/// Smaller arrays are stored without checksum and compression, which cost more than they save: each
/// chunked array has an index of 2 KB.
constexpr std::size_t smallest_chunked = 4096;
/// Largest number of values in a chunk, so that a reader of a part need not unpack the whole.
constexpr hsize_t chunk_values = 1 << 17;
/// Higher levels take longer and save nothing on shuffled doubles: 22 frames take 2.6 MB at levels
/// 1 and 4.
constexpr unsigned deflate_level = 1;
/// Limits of the number of values that a file is trusted to contain, so that a damaged or hostile
/// file of kilobytes cannot ask for all the memory. Deflate expands a byte to at most 1032; fill
/// values need not be stored at all.
constexpr double most_values_per_byte = 1032.0;
constexpr double most_fill_values = 1e6;

/// The cause of the last failure as reported by the library: the innermost message and the system
/// error number.
struct LibraryError {
  std::string message;
  int system_code = EIO;
};

/// Callback that stores the innermost message of the library. It must not throw: the library holds
/// its lock, which would stay locked.
/// @param result  a LibraryError
herr_t keep_innermost(unsigned depth, const H5E_error2_t* entry, void* result) try {
  auto& error = *static_cast<LibraryError*>(result);

  // The rest of the text repeats time, file and buffer; the error number is reported separately.
  if (depth == 0)
    error.message = std::string(entry->desc).substr(0, std::string(entry->desc).find(": time ="));
  if (entry->maj_num == H5E_RESOURCE) error.system_code = ENOMEM;

  // The library reports errno only as text.
  const std::string text = entry->desc;
  const std::string key = "errno = ";
  if (const auto begin = text.find(key); begin != std::string::npos)
    error.system_code = std::atoi(text.c_str() + begin + key.size());
  return 0;
} catch (const std::bad_alloc&) {
  static_cast<LibraryError*>(result)->system_code = ENOMEM;
  return -1;
}

LibraryError last_error() {
  LibraryError error;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &error);
  return error;
}

/// Keeps the library from printing every failure to stderr, even those that are handled. The
/// setting is per thread.
void disable_error_printing() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

/// Types of a number in the file and in memory.
std::pair<hid_t, hid_t> number_types(double) {
  return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE};
}

std::pair<hid_t, hid_t> number_types(std::int32_t) {
  return {H5T_STD_I32LE, H5T_NATIVE_INT32};
}

std::pair<hid_t, hid_t> number_types(std::int64_t) {
  return {H5T_STD_I64LE, H5T_NATIVE_INT64};
}

/// How files are opened: without the library's locks, which could keep a program from a file for as
/// long as another one has it open.
Handle file_access() {
  Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access.get(), false, true);
  return access;
}

Handle make_space(const Shape& shape) {
  if (shape.empty()) return {H5Screate(H5S_SCALAR), H5Sclose};
  return {H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose};
}

/// Storage layout of a dataset. Times are not stored: the same run gives the same bytes.
Handle make_layout(const Shape& shape) {
  Handle layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(layout.get(), false);
  if (shape.empty() || count_values(shape) < smallest_chunked) return layout;

  const hsize_t row = count_values(shape) / shape[0];
  Shape chunk = shape;
  chunk[0] = std::min(shape[0], std::max<hsize_t>(1, chunk_values / row));
  H5Pset_chunk(layout.get(), static_cast<int>(chunk.size()), chunk.data());
  H5Pset_shuffle(layout.get());
  H5Pset_deflate(layout.get(), deflate_level);
  H5Pset_fletcher32(layout.get());
  return layout;
}

/// Copies strings that the library allocated, and frees them.
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

std::size_t count_values(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
}

template <class Result>
Result File::checked(Result result, const std::string& object, const char* failure) const {
  if (result >= 0) return result;
  const LibraryError cause = last_error();
  throw storage::StorageError(cause.system_code, fmt::format("{}:{}", path_.string(), object),
                              fmt::format("{} ({})", failure, cause.message));
}

File File::create(const std::filesystem::path& path) {
  disable_error_printing();
  const Handle access = file_access();
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_EARLIEST, H5F_LIBVER_V18);
  File file(path,
            Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose));
  file.checked(file.id_.get(), "/", "cannot be created");
  return file;
}

File File::open(const std::filesystem::path& path) {
  disable_error_printing();
  const Handle access = file_access();
  File file(path, Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose));
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
  const Handle space = make_space(shape);
  const Handle layout = make_layout(unit == nullptr ? Shape{} : shape);  // texts are not chunked
  const Handle dataset(H5Dcreate2(id_.get(), object.c_str(), file_type, space.get(), H5P_DEFAULT,
                                  layout.get(), H5P_DEFAULT),
                       H5Dclose);
  checked(dataset.get(), object, "cannot be created");

  if (count_values(shape) > 0)
    checked(H5Dwrite(dataset.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), object,
            "cannot be written");
  for (const char* const name : {"unit", "units"})
    if (unit != nullptr) put_attribute(dataset, object, name, unit);
  put_attribute(dataset, object, "meaning", meaning);
}

template <class Number>
void File::write(const std::string& object, const Shape& shape, const std::vector<Number>& values,
                 const char* unit, const char* meaning) {
  const auto [in_file, in_memory] = number_types(Number{});
  write_array(object, shape, in_file, in_memory, values.data(), unit, meaning);
}

void File::attach_scale(const std::string& scale, const std::string& object, unsigned dimension) {
  const Handle places = open_object(scale), values = open_object(object);
  if (H5DSis_scale(places.get()) == 0)
    checked(H5DSset_scale(places.get(), nullptr), scale, "cannot become a scale");
  checked(H5DSattach_scale(values.get(), places.get(), dimension), object, "cannot get a scale");
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
  const Handle space = make_space({});
  const Handle attribute(
      H5Acreate2(target.get(), name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const std::string full_name = fmt::format("{}@{}", object, name);
  checked(attribute.get(), full_name, "cannot be created");
  checked(H5Awrite(attribute.get(), type, value), full_name, "cannot be written");
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
  const std::string full_name = fmt::format("{}@{}", object, name);
  const Handle owner = open_object(object);
  const Handle attribute(H5Aopen(owner.get(), name, H5P_DEFAULT), H5Aclose);
  checked(attribute.get(), full_name, "is not in the file");
  const Handle space(H5Aget_space(attribute.get()), H5Sclose);
  if (H5Sget_simple_extent_npoints(space.get()) != 1)
    throw storage::StorageError(EINVAL, fmt::format("{}:{}", path_.string(), full_name),
                                "is not a single value");
  checked(H5Aread(attribute.get(), type, value), full_name, "cannot be read");
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

/// The lengths are not trusted before their product is compared with the stored bytes.
std::size_t File::checked_count(const std::string& object,
                                std::optional<std::size_t> required) const {
  const Handle dataset = open_object(object);
  const double stored = std::min(static_cast<double>(H5Dget_storage_size(dataset.get())),
                                 static_cast<double>(std::filesystem::file_size(path_)));

  // As a real number: the product of hostile lengths overflows an integer.
  const Shape shape = shape_of(object);
  double count = 1.0;
  for (const hsize_t length : shape) count *= static_cast<double>(length);
  if (count > most_fill_values + most_values_per_byte * stored ||
      (required && count_values(shape) != *required))
    throw storage::StorageError(EINVAL, fmt::format("{}:{}", path_.string(), object),
                                "has the wrong shape");
  return count_values(shape);
}

void File::read_array(const std::string& object, hid_t memory_type, void* values) const {
  const Handle dataset = open_object(object);
  checked(H5Dread(dataset.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), object,
          "cannot be read");
}

std::vector<double> File::read_reals(const std::string& object,
                                     std::optional<std::size_t> count) const {
  std::vector<double> values(checked_count(object, count));
  if (!values.empty()) read_array(object, H5T_NATIVE_DOUBLE, values.data());
  return values;
}

std::vector<std::int64_t> File::read_integers(const std::string& object,
                                              std::optional<std::size_t> count) const {
  std::vector<std::int64_t> values(checked_count(object, count));
  if (!values.empty()) read_array(object, H5T_NATIVE_INT64, values.data());
  return values;
}

std::vector<std::string> File::read_texts(const std::string& object,
                                          std::optional<std::size_t> count) const {
  std::vector<char*> texts(checked_count(object, count), nullptr);
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

}  // namespace dccast::results::hdf5
