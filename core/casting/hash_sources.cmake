# Writes a C++ source with a digest of every source of core/: cmake -DCORE=... -DOUTPUT=... -P
file(GLOB_RECURSE sources RELATIVE ${CORE} ${CORE}/*.cpp ${CORE}/*.hpp)
list(SORT sources)
set(digests "")
foreach(source ${sources})
  file(SHA256 ${CORE}/${source} digest)
  string(APPEND digests "${source} ${digest}\n")
endforeach()
string(SHA256 digest "${digests}")
string(SUBSTRING ${digest} 0 16 digest)
file(WRITE ${OUTPUT} "namespace dccast::casting {
extern const char core_sources[];
const char core_sources[] = \"${digest}\";
}
")
