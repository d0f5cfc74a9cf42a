# Writes OUTPUT, a C++ source that holds the text of the files ASSETS (a list of paths)
# Run by `cmake -P`, see client/CMakeLists.txt.
set(source "// Written by embed_assets.cmake.\n#include \"client/web/assets.hpp\"\n\nnamespace dccast::client::web {\n\n"
  "const std::vector<Asset>& assets() {\n  static const std::vector<Asset> all = {\n")
string(JOIN "" source ${source})
foreach(file IN LISTS ASSETS)
  get_filename_component(name ${file} NAME)
  file(READ ${file} text)
  string(APPEND source "      {\"${name}\", R\"dccast_text(${text})dccast_text\"},\n")
endforeach()
string(APPEND source "  };\n  return all;\n}\n\n}  // namespace dccast::client::web\n")
file(WRITE ${OUTPUT} "${source}")
