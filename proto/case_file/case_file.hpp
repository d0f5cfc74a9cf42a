#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include "dccast/v1/job.pb.h"
#include "proto/case_file/source_map.hpp"

/// TOML with units <-> any message of the schema (Case, Alloy, DaemonConfig), by reflection over
/// the (key) options of options.proto. Keys are field names without their unit suffix, quantities
/// are strings with a unit, enums are lower-case value names.
///
/// The client calls `read_file` and sends only the keys of the file. The server calls
/// `apply_defaults`, `complete_alloy` (alloy_cards.hpp) and `check_ranges`, so that cases of all
/// clients are treated in the same way.
namespace dccast::case_file {

/// A file larger than this is refused before it is parsed [bytes].
inline constexpr std::size_t maximum_file_bytes = 4 * 1024 * 1024;

/// A file of this machine that a case names.
struct AttachedFile {
  std::string name;  ///< that the case gives it
  std::filesystem::path path{};
  /// SHA-256 of a file that the case names, by which the server finds it.
  std::string sha256{};
  std::int64_t bytes = 0;
};

/// Result of reading a file, besides the message.
struct ReadOutcome {
  std::vector<v1::Fault> faults;          ///< empty: the message is complete and in range
  std::vector<std::string> missing_keys;  ///< paths of absent required keys; each has a fault
  std::vector<AttachedFile> attachments;  ///< files named by attachment fields
  std::vector<std::string> files;         ///< names of these files, if the text was read elsewhere
  SourceMap source;

  /// Whether the text was read without a fault.
  bool ok() const { return faults.empty(); }
};

/// Reads a TOML file into `message`. All faults are collected: unknown key, missing or wrong unit,
/// out of range, NaN, table not increasing, required key absent, broken TOML. The message contains
/// everything that could be read. Files named by attachment fields are looked up relative to the
/// folder of the file, and their SHA-256 is computed; the value of the field becomes the base name
/// of its file. No default is applied. Does not throw, whatever the content of the file.
ReadOutcome read_file(const std::filesystem::path& file, google::protobuf::Message& message);

/// Reads a text. @param name  of the file, for positions  @param folder  of attachments
ReadOutcome read_text(std::string_view text, const std::string& name,
                      google::protobuf::Message& message, const std::filesystem::path& folder = {});

/// Reads a text of another machine: no file of this one is read. Files are listed as the text names
/// them, and the value of their field becomes the base name.
ReadOutcome read_elsewhere(std::string_view text, const std::string& name,
                           google::protobuf::Message& message);

/// Fills every absent key that has a default. In an Alloy *inside* another message only `card` is
/// filled: a default must not hide the value of the card, see `complete_alloy`.
/// Idempotent; may be called from several threads.
void apply_defaults(google::protobuf::Message& message);

/// Checks a message from any source: required keys, ranges, finite numbers, known enum values,
/// lengths of texts and tables, well-formed curves (as many values as abscissae, strictly
/// increasing, a permitted abscissa). Absent keys that are not required are permitted.
/// @return all faults, with paths as in a file
std::vector<v1::Fault> check_ranges(const google::protobuf::Message& message);

/// Writes the keys that are present as a TOML file that reads back to the same message.
std::string to_toml(const google::protobuf::Message& message);

/// All keys that are present with their values as in a file, in the order of the schema. Tables are
/// flattened: "monitor[0].x", "0.28 m".
std::vector<std::pair<std::string, std::string>> key_values(
    const google::protobuf::Message& message);

/// One row of the reference of all keys.
struct KeyReference {
  std::string path;  ///< "schedule.casting_speed"; "monitor[].x" in arrays of tables
  std::string type;  ///< "quantity", "number", "integer", "flag", "text", "choice", "file", "table"
  std::string unit;  ///< schema unit; empty when there is none
  std::string permitted;  ///< range or choices, as text
  std::string against;    ///< for curves: "time, cast length"
  std::string default_text;
  /// Comment of the field in case.proto.
  std::string doc;
  bool curve = false;  ///< a table of pairs may be given instead of one value
  bool required = false;
  std::string size;         ///< "at most 200 bytes", "at most 1000 entries"; empty for other keys
  std::string uncertainty;  ///< range of the default, as in [uncertainty]
};

/// Every key of a message, in the order of the schema; tables before their keys. Made once for each
/// message.
const std::vector<KeyReference>& reference(const google::protobuf::Descriptor& descriptor);

}  // namespace dccast::case_file
