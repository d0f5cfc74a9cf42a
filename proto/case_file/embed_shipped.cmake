# Writes OUTPUT, a C++ source that holds the text of the files CASES and ALLOYS (lists of paths).
# Run by `cmake -P`, see CMakeLists.txt.
function(append_table function_name files)
  string(APPEND source "const std::vector<ShippedText>& ${function_name}() {\n"
    "  static const std::vector<ShippedText> texts = {\n")
  foreach(file IN LISTS files)
    get_filename_component(name ${file} NAME_WE)
    file(READ ${file} text)
    string(APPEND source "      {\"${name}\", R\"dccast_text(${text})dccast_text\"},\n")
  endforeach()
  string(APPEND source "  };\n  return texts;\n}\n\n")
  set(source "${source}" PARENT_SCOPE)
endfunction()

set(source "// Written by embed_shipped.cmake from cases/.\n#include \"proto/case_file/shipped.hpp\"\n\n"
  "namespace dccast::shipped {\n\n")
string(JOIN "" source ${source})
append_table(case_templates "${CASES}")
append_table(alloy_cards "${ALLOYS}")
string(APPEND source "}  // namespace dccast::shipped\n")
file(WRITE ${OUTPUT} "${source}")
