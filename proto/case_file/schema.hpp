#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"
#include "dccast/v1/options.pb.h"

/// Access to the (key) options of a field, and the checks of values that follow from them. Shared
/// by the reader, the checks, the writer and the reference.
namespace dccast::case_file {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

/// Shown as the default of the keys that `apply_quality` fills.
inline constexpr std::string_view by_quality = "by quality";

/// The (key) option of a field.
const v1::Key& key_of(const FieldDescriptor& field);

/// Name in a case file: the field's name without the suffix of its unit.
/// @throws std::logic_error  the field's name does not end in this suffix: an error in the schema
std::string toml_key(const FieldDescriptor& field);

/// All fields of a message, in the order of the schema.
std::vector<const FieldDescriptor*> fields_of(const Descriptor& descriptor);

/// The field of `descriptor` with this key in a case file, or null.
const FieldDescriptor* field_of_key(const Descriptor& descriptor, std::string_view key);

/// The enum value with a text in a case file ("plane_strain"); null if there is none. The
/// unspecified value has no text.
const google::protobuf::EnumValueDescriptor* enum_value_of(const FieldDescriptor& field,
                                                           std::string_view text);
/// The texts of all enum values.
std::vector<std::string> enum_texts(const FieldDescriptor& field);
/// In lower case (ASCII).
std::string lower(std::string text);

/// A nested message that is a table of values.
bool is_curve(const FieldDescriptor& field);
/// A nested message that is an alloy.
bool is_alloy(const FieldDescriptor& field);
/// A nested message that is a table of the file (not a Curve).
bool is_table(const FieldDescriptor& field);

/// The lines KEY = RANGE of a table [uncertainty].
bool is_ranges(const FieldDescriptor& field);

/// Whether a value of the field is the name of a file that travels with the case.
bool names_file(const FieldDescriptor& field, std::string_view value);

/// Whether the field has a value: it is set, or not empty (text), or not unspecified (enums).
bool is_present(const Message& message, const FieldDescriptor& field);

/// The number of a field that holds one and is present [unit of the schema].
std::optional<double> number_of(const Message& message, const FieldDescriptor& field);

/// The table of a field that is_curve(); empty if the field is absent.
v1::Curve curve_of(const Message& message, const FieldDescriptor& field);
/// A table as the value of a key in a file. @param unit  of its values
std::string curve_text(const v1::Curve& curve, const std::string& unit);

/// Unit of an abscissa in UDUNITS-2 syntax, and its name in texts ("cast length").
std::string abscissa_unit(v1::Abscissa abscissa);
/// The quantity that a table stands against, such as "cast length".
std::string abscissa_name(v1::Abscissa abscissa);
/// The abscissae that a table may have.
std::vector<v1::Abscissa> abscissae_of(const FieldDescriptor& field);

/// "schedule" + "hold" -> "schedule.hold"; no dot at the root.
std::string join_path(const std::string& parent, const std::string& key);

/// "monitor" and 1 -> "monitor[1]".
std::string element_path(const std::string& list, std::size_t element);

/// "a, b, c".
std::string joined(const std::vector<std::string>& words);

/// The range of a field: "0 to 0.1 m/s", "more than 0 Pa", "at least 1"; empty without a range.
/// @param other_unit  if given, the range is repeated in this unit: "(0 to 6000 mm/min)"
std::string range_text(const FieldDescriptor& field, const std::string& other_unit = {});

/// The fault of a number outside the range of its field; empty if there is none.
/// @param value  [unit of the field]
std::optional<v1::Fault> range_fault(const FieldDescriptor& field, double value,
                                     const std::string& path, const std::string& written,
                                     const std::string& unit_written);

// A case is stored, listed and reported by a daemon that serves several users. Therefore every text
// and table has a limit of size: its own, or the general one.

/// "at most 200 bytes", "at most 1000 entries", "at most 10000 points"; empty for other keys.
std::string size_text(const FieldDescriptor& field);

/// The fault of a text that is too long, or has a character that acts on a terminal or a log; empty
/// if there is none. The fault contains only the beginning of the text.
std::optional<v1::Fault> text_fault(const FieldDescriptor& field, const std::string& text,
                                    const std::string& path);

/// The fault of too many entries or points; empty if there is none.
std::optional<v1::Fault> count_fault(const FieldDescriptor& field, std::size_t count,
                                     const std::string& path);

/// The fault of a required key that is absent.
v1::Fault missing_fault(const FieldDescriptor& field, const std::string& path);

/// Creates a fault. The value is shortened, so that no fault repeats a long text.
v1::Fault make_fault(std::string path, const std::string& value, std::string message,
                     std::string permitted = {}, std::string remedy = {});

/// An example of a value of this field, as in a file: `"60 mm/min"`.
std::string example_text(const FieldDescriptor& field);

}  // namespace dccast::case_file
