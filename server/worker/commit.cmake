# Writes a C++ source with the commit of a checkout: cmake -DSOURCE=... -DOUTPUT=... -P
# "-dirty" is added where files differ from it; "unknown" without git.
find_program(GIT git)
set(commit "")
if(GIT)
  execute_process(COMMAND ${GIT} -C ${SOURCE} describe --always --dirty --abbrev=40 --exclude=*
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT commit MATCHES "^[0-9a-f]+(-dirty)?$")
  set(commit unknown)
endif()
# Only a new commit is written, so that nothing is compiled again without a reason.
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "namespace dccast::worker {
extern const char commit[];
const char commit[] = \"${commit}\";
}
")
