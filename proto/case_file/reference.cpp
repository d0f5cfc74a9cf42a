#include "proto/case_file/case_file.hpp"
#include "proto/case_file/schema.hpp"
#include "proto/case_file/size_bounds.hpp"

namespace dccast::case_file {
namespace {

std::string type_of(const FieldDescriptor& field) {
  if (is_table(field)) return "table";
  if (is_curve(field)) return key_of(field).unit() == "1" ? "number" : "quantity";
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_ENUM:
      return "choice";
    case FieldDescriptor::CPPTYPE_BOOL:
      return "flag";
    case FieldDescriptor::CPPTYPE_STRING:
      return key_of(field).attachment() ? "file" : "text";
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return key_of(field).unit() == "1" ? "number" : "quantity";
    default:
      return "integer";
  }
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

KeyReference describe_field(const FieldDescriptor& field, const std::string& path) {
  const v1::Key& key = key_of(field);
  KeyReference row{path,
                   type_of(field),
                   key.unit(),
                   range_text(field),
                   "",
                   key.default_text(),
                   key.doc(),
                   is_curve(field),
                   key.required(),
                   "",
                   key.uncertainty()};
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM) row.permitted = joined(enum_texts(field));
  std::vector<std::string> against;
  for (const v1::Abscissa abscissa : abscissae_of(field))
    against.push_back(abscissa_name(abscissa));
  row.against = joined(against);
  row.size = size_text(field);
  return row;
}

void append(const Descriptor& descriptor, const std::string& parent,
            std::vector<KeyReference>& rows) {
  for (int i = 0; i < descriptor.field_count(); ++i) {
    const FieldDescriptor& field = *descriptor.field(i);
    const bool list = field.is_repeated() && !is_ranges(field);
    const std::string path = join_path(parent, toml_key(field)) + (list ? "[]" : "");
    rows.push_back(describe_field(field, path));
    if (is_table(field) && !is_ranges(field)) append(*field.message_type(), path, rows);
  }
}

}  // namespace

std::vector<KeyReference> reference(const Descriptor& descriptor) {
  std::vector<KeyReference> rows;
  append(descriptor, "", rows);
  return rows;
}

}  // namespace dccast::case_file
