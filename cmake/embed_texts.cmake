# Writes OUTPUT, a C++ source with a function for each name in TABLES, which returns names and texts of the
# files in the variable of that name: `const std::vector<TYPE>& NAME()` in NAMESPACE, as HEADER declares.
# A name is that of the file, without `.toml`. Run by `cmake -P`.
set(source "// Written by embed_texts.cmake.\n#include \"${HEADER}\"\n\nnamespace ${NAMESPACE} {\n\n")
foreach(table IN LISTS TABLES)
  string(APPEND source "const std::vector<${TYPE}>& ${table}() {\n  static const std::vector<${TYPE}> texts = {\n")
  foreach(file IN LISTS ${table})
    get_filename_component(name ${file} NAME)
    string(REGEX REPLACE "\\.toml$" "" name ${name})
    file(READ ${file} text)
    string(APPEND source "      {\"${name}\", R\"dccast_text(${text})dccast_text\"},\n")
  endforeach()
  string(APPEND source "  };\n  return texts;\n}\n\n")
endforeach()
string(APPEND source "}  // namespace ${NAMESPACE}\n")
file(WRITE ${OUTPUT} "${source}")
